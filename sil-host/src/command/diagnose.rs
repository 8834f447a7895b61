//! `sil diagnose`: what the simulation gets wrong, its cause, the extended model, the gain on held-out data.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sil_host::answer::board_parameters::{board_parameters, params_file, without_parameters};
use sil_host::answer::{Answered, HeldAgainst, Row, Said, baseline, several_json, several_page, several_text};
use sil_host::diagnosis::{BetweenFlights, Effort, Fact, Given, Verdict, diagnose_against};
use sil_host::log::Log;

use super::log_arguments::{LogArguments, quoted};
use super::output::emphasised;
use super::progress_line::ProgressLine;
use super::{Failure, bad_input, print, write_file, write_json};

/// Find what the simulation gets wrong in a measured log, and name the cause
#[derive(Args)]
#[command(
    after_help = "Example: sil diagnose out/rig.csv --report out/diagnosis.html   (sil synth out/rig.csv makes a log)\n\
Example: sil diagnose bench.csv.gz --map antx\n\
Example: sil diagnose today.csv --baseline normal1.csv --baseline normal2.csv\n\
Example: sil diagnose flights/*.ulg --report out/flights.html   (one table)\n\
Example: sil diagnose LOG00001.ULG --model models/f450-gimbal.toml --params out/better.params   (to fly better)\n\n\
Effects are fitted to half of the log, in windows of 0.5 s, chosen by a quarter, judged by the rest. Then\n\
`sil compare LOG --model out/extended.toml` shows what remains. docs/reading-a-diagnosis.md explains the figures."
)]
pub struct DiagnoseArguments {
    #[command(flatten)]
    log: LogArguments,
    /// More logs, each with its own answer, all in one table; one that can't be read is a row that says why
    #[arg(value_name = "MORE", conflicts_with_all = ["baseline", "extended", "params", "experiment"])]
    more: Vec<PathBuf>,
    /// Search the whole log only, not other cuts of it: the answer comes sooner, and without how far it hangs on where
    /// the log was cut
    #[arg(long, conflicts_with = "thorough")]
    quick: bool,
    /// Search 24 other cuts of the log instead of 8
    #[arg(long)]
    thorough: bool,
    /// A number that was weighed or measured, held: NAME=VALUE or NAME=VALUE+-STD; may be given several times. Names:
    /// mass_kg, ixx_kg_m2, iyy_kg_m2, izz_kg_m2, thrust_scale, time_constant_s, motor_lag_s, delay_s
    #[arg(long, value_name = "NAME=VALUE")]
    known: Vec<String>,
    /// Compare with this log of a normal flight of the same vehicle, and report only the difference; may be given
    /// several times
    #[arg(long, value_name = "NORMAL", conflicts_with_all = ["extended", "params", "experiment"])]
    baseline: Vec<PathBuf>,
    /// With --baseline: nothing was changed between these flights but what is sought (no propeller, no battery moved),
    /// so that only what repeats from flight to flight is chance
    #[arg(long, requires = "baseline")]
    untouched: bool,
    /// Write the model with the findings and the base model in it
    #[arg(long, value_name = "OUT.toml")]
    extended: Option<PathBuf>,
    /// Write the parameters with which a board flies the vehicle of --extended, as a ground station loads them
    #[arg(long, value_name = "OUT.params")]
    params: Option<PathBuf>,
    /// Write the flight that would separate effects which this log cannot, for `sil fly --script`
    #[arg(long, value_name = "OUT.toml")]
    experiment: Option<PathBuf>,
    /// End with exit status 3 on such an answer: discrepancy for any, unexplained where the findings don't explain it
    #[arg(long, value_name = "WHAT", value_enum)]
    fail_on: Option<FailOn>,
    /// Write a report for the browser
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the answer as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// Answers that a script may want to stop at.
#[derive(Clone, Copy, ValueEnum)]
enum FailOn {
    /// Anything but "no discrepancy".
    Discrepancy,
    /// What the findings do not explain.
    Unexplained,
}

impl DiagnoseArguments {
    fn effort(&self) -> Effort {
        match (self.quick, self.thorough) {
            (true, _) => Effort::Quick,
            (_, true) => Effort::Thorough,
            _ => Effort::Usual,
        }
    }

    /// The option that separate axes can't serve.
    fn wants_vehicle(&self) -> Option<&'static str> {
        let extended = self.extended.as_ref().map(|_| "--extended");
        let params = self.params.as_ref().map(|_| "--params");
        extended.or(params).or(self.experiment.as_ref().map(|_| "--experiment"))
    }

    fn facts(&self) -> Result<Vec<Fact>, Failure> {
        let facts: Result<_, _> = self.known.iter().map(|text| Fact::parse(text)).collect();
        facts.map_err(|error| bad_input(format!("--known {error}")))
    }

    /// The flight against normal ones.
    fn against_baseline(&self, log: &Log, said: &Said, facts: &[Fact]) -> Result<(), Failure> {
        if let Some(option) = self.log.controller_option() {
            return Err(bad_input(format!("--baseline compares flights, not controllers: leave out {option}")));
        }
        let normal = self.baseline.iter().map(|path| self.log.read_examined(path)).collect::<Result<Vec<Log>, _>>()?;
        let against = {
            let line = ProgressLine::new();
            HeldAgainst::of_normal(&normal, said, facts, &|progress| line.show(progress)).map_err(bad_input)?
        };
        print(against.text())?;
        let answer = {
            let line = ProgressLine::new();
            let between = if self.untouched { BetweenFlights::Untouched } else { BetweenFlights::Serviced };
            let given = Given { known: &against.known, between };
            diagnose_against(log, &normal, &against.subject(), given, &|progress| line.show(progress))
                .map_err(bad_input)?
        };
        print(baseline::text(&answer))?;
        if let Some(path) = &self.report {
            let page = against.on_page(baseline::page(&answer, &self.command()));
            write_file(path, page.to_html().as_bytes())?;
            print(format!("report          {}\n", path.display()))?;
        }
        write_json(self.json.as_deref(), &answer)?;
        self.judged(answer.verdict)
    }

    /// Several logs, one answer each.
    fn each(&self, said: &Said, facts: &[Fact]) -> Result<(), Failure> {
        let paths: Vec<&Path> = [self.log.path()].into_iter().chain(self.more.iter().map(PathBuf::as_path)).collect();
        let mut rows = Vec::new();
        for path in &paths {
            let line = ProgressLine::of_several(rows.len() + 1, paths.len());
            let answered = self.log.read_examined(path).and_then(|log| {
                let show = |progress| line.show(progress);
                let against = HeldAgainst::of(&log, said, facts, None, &show).map_err(bad_input)?;
                Answered::of(log, against, self.effort(), &show).map_err(bad_input)
            });
            rows.push(Row::of(path, answered.map_err(|failure| failure.message)));
        }
        print(several_text(&rows))?;
        if let Some(path) = &self.report {
            write_file(path, several_page(&rows, &self.command()).to_html().as_bytes())?;
            print(format!("report          {}\n", path.display()))?;
        }
        write_json(self.json.as_deref(), &several_json(&rows))?;
        // what scripts were to stop at weighs more than a file that can't be read
        rows.iter().filter_map(Row::verdict).try_for_each(|verdict| self.judged(verdict))?;
        match rows.iter().filter(|row| row.verdict().is_none()).count() {
            0 => Ok(()),
            failed => Err(bad_input(format!("{failed} of {} logs have no answer, see the table", rows.len()))),
        }
    }

    /// Writes what was requested of a vehicle's diagnosis: the extended model, the flight to fly next.
    fn write_models(&self, answered: &Answered) -> Result<(), Failure> {
        if let (Some(path), Some(extended)) = (&self.extended, answered.extended().map_err(bad_input)?) {
            write_file(path, extended.to_toml().as_bytes())?;
            print(format!("extended model  {}\n", path.display()))?;
        }
        if let (Some(path), Some(extended)) = (&self.params, answered.extended().map_err(bad_input)?) {
            let parameters = board_parameters(&extended).map_err(|reason| bad_input(format!("--params: {reason}")))?;
            write_file(path, params_file(&extended.name, &parameters).as_bytes())?;
            let without = match without_parameters(&extended) {
                names if names.is_empty() => String::new(),
                names => format!("   (a board has no parameter for {})", names.join(", ")),
            };
            print(format!("parameters      {}{without}\n", path.display()))?;
        }
        let Some(path) = &self.experiment else { return Ok(()) };
        match answered.diagnosis.experiment.as_ref().and_then(|experiment| experiment.scenario.as_ref()) {
            Some(scenario) => {
                write_file(path, scenario.to_script().as_bytes())?;
                print(format!("experiment      {}\n", path.display()))
            }
            None => print("experiment      none: no effects to separate, or no flight that would\n"),
        }
    }

    /// A failure where scripts wanted one.
    fn judged(&self, verdict: Verdict) -> Result<(), Failure> {
        let is_bad = match self.fail_on {
            None => false,
            Some(FailOn::Discrepancy) => verdict != Verdict::NoDiscrepancy,
            Some(FailOn::Unexplained) => !matches!(verdict, Verdict::NoDiscrepancy | Verdict::Explained),
        };
        if is_bad {
            Err(Failure { status: 3, message: "the log is not as the simulation (--fail-on)".into() })
        } else {
            Ok(())
        }
    }

    /// How it was called, for the page.
    fn command(&self) -> String {
        let mut command = self.log.command("diagnose", &self.more);
        for fact in &self.known {
            command.push_str(&format!(" --known {fact}"));
        }
        for normal in &self.baseline {
            command.push_str(&format!(" --baseline {}", quoted(&normal.display().to_string())));
        }
        let flags = [("--untouched", self.untouched), ("--quick", self.quick), ("--thorough", self.thorough)];
        for (flag, _) in flags.into_iter().filter(|(_, is_set)| *is_set) {
            command.push_str(&format!(" {flag}"));
        }
        command
    }
}

pub fn run(arguments: &DiagnoseArguments) -> Result<(), Failure> {
    let (said, facts) = (arguments.log.said()?, arguments.facts()?);
    if !arguments.more.is_empty() {
        return arguments.each(&said, &facts);
    }
    let log = arguments.log.read_examined(arguments.log.path())?;
    if !arguments.baseline.is_empty() {
        return arguments.against_baseline(&log, &said, &facts);
    }
    let against = {
        let (line, wants) = (ProgressLine::new(), arguments.wants_vehicle());
        HeldAgainst::of(&log, &said, &facts, wants, &|progress| line.show(progress)).map_err(bad_input)?
    };
    print(against.text())?;
    let answered = {
        let line = ProgressLine::new();
        Answered::of(log, against, arguments.effort(), &|progress| line.show(progress)).map_err(bad_input)?
    };
    print(answered.text(emphasised))?;
    if let Some(path) = &arguments.report {
        write_file(path, answered.page(&arguments.command()).to_html().as_bytes())?;
        print(format!("report          {}\n", path.display()))?;
    }
    write_json(arguments.json.as_deref(), &answered.diagnosis)?;
    // the last, for not every vehicle can be written in a board's parameters
    arguments.write_models(&answered)?;
    arguments.judged(answered.diagnosis.verdict)
}
