//! `sil diagnose`: what the simulation gets wrong, its cause, the extended model, the gain on held-out data.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sil_host::closed_loop::LogRefused;
use sil_host::diagnosis::{
    BetweenFlights, Effort, Fact, Given, Known, Subject, Verdict, diagnose_against, diagnose_flown_by,
    diagnose_observed, extended_model,
};
use sil_host::log::Log;
use sil_host::model::VehicleModel;

use super::log_arguments::{LogArguments, quoted};
use super::log_subject::chosen;
use super::progress_line::ProgressLine;
use super::{
    Failure, bad_input, baseline_report, diagnose_report, diagnose_text, identify, print, write_file, write_json,
};

/// Find what the simulation gets wrong in a measured log, and name the cause
#[derive(Args)]
#[command(
    after_help = "Example: sil diagnose out/rig.csv --report out/diagnosis.html   (sil synth out/rig.csv makes a log)\n\
Example: sil diagnose bench.csv.gz --map antx\n\
Example: sil diagnose today.csv --baseline normal1.csv --baseline normal2.csv\n\n\
Effects are fitted to half of the log, in windows of 0.5 s, chosen by a quarter, judged by the rest. Then\n\
`sil compare LOG --model out/extended.toml` shows what remains. docs/reading-a-diagnosis.md explains the figures."
)]
pub struct DiagnoseArguments {
    #[command(flatten)]
    log: LogArguments,
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
    #[arg(long, value_name = "NORMAL", conflicts_with_all = ["extended", "experiment"])]
    baseline: Vec<PathBuf>,
    /// With --baseline: nothing was changed between these flights but what is sought (no propeller, no battery moved),
    /// so that only what repeats from flight to flight is chance
    #[arg(long, requires = "baseline")]
    untouched: bool,
    /// Write the model with the findings in it
    #[arg(long, value_name = "OUT.toml")]
    extended: Option<PathBuf>,
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
        let experiment = self.experiment.as_ref().map(|_| "--experiment");
        extended.or(experiment).or(self.known.first().map(|_| "--known"))
    }

    /// The flight against normal ones.
    fn against_baseline(&self, log: &Log, model: Option<&VehicleModel>, known: &Known) -> Result<(), Failure> {
        if let Some(option) = self.log.controller_option() {
            return Err(bad_input(format!("--baseline compares flights, not controllers: leave out {option}")));
        }
        let normal = self.baseline.iter().map(|path| self.log.read_other(path)).collect::<Result<Vec<Log>, _>>()?;
        let subject = model.map_or(Subject::Axes, Subject::Vehicle);
        let answer = {
            let line = ProgressLine::new();
            let between = if self.untouched { BetweenFlights::Untouched } else { BetweenFlights::Serviced };
            let given = Given { known, between };
            diagnose_against(log, &normal, &subject, given, &|progress| line.show(progress)).map_err(bad_input)?
        };
        print(baseline_report::text(&answer))?;
        if let Some(path) = &self.report {
            let page = baseline_report::page(&answer, &self.command());
            write_file(path, page.to_html().as_bytes())?;
            print(format!("report          {}\n", path.display()))?;
        }
        write_json(self.json.as_deref(), &answer)?;
        self.judged(answer.verdict)
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
        let mut command = self.log.command("diagnose");
        for fact in &self.known {
            command.push_str(&format!(" --known {fact}"));
        }
        for normal in &self.baseline {
            command.push_str(&format!(" --baseline {}", quoted(&normal.display().to_string())));
        }
        if self.untouched {
            command.push_str(" --untouched");
        }
        command
    }

    /// The model with what is known in place of its own numbers.
    fn with_known(&self, model: Option<VehicleModel>) -> Result<(Option<VehicleModel>, Known), Failure> {
        let Some(model) = model else { return Ok((None, Known::default())) };
        let facts: Result<Vec<Fact>, _> = self.known.iter().map(|text| Fact::parse(text)).collect();
        let known = facts.and_then(|facts| Known::of(&model, &facts));
        let (model, known) = known.map_err(|error| bad_input(format!("--known {error}")))?;
        Ok((Some(model), known))
    }
}

pub fn run(arguments: &DiagnoseArguments) -> Result<(), Failure> {
    let log = arguments.log.read()?;
    let controller = arguments.log.controller()?;
    if !arguments.baseline.is_empty() {
        let model = arguments.log.vehicle(&log, arguments.wants_vehicle())?;
        let (model, known) = arguments.with_known(model)?;
        return arguments.against_baseline(&log, model.as_ref(), &known);
    }
    let chosen = chosen(&arguments.log, &log, arguments.wants_vehicle())?;
    let (model, known) = arguments.with_known(chosen.vehicle)?;
    if !chosen.said.is_empty() {
        print(format!("{}\n", chosen.said))?;
    }
    if let Some(identified) = &chosen.identified {
        print(format!("{}\n", identify::table(identified)))?;
    }
    let effort = arguments.effort();
    let answer = {
        let line = ProgressLine::new();
        let observer = |progress| line.show(progress);
        match (&model, controller) {
            (Some(model), Some(choice)) => diagnose_flown_by(&log, model, choice, &known, effort, &observer),
            (Some(model), None) => {
                diagnose_observed(&log, &Subject::Vehicle(model), &known, effort, &observer).map_err(LogRefused::from)
            }
            (None, _) => {
                let axes = chosen.bench.as_ref().map_or(Subject::Axes, Subject::Bench);
                diagnose_observed(&log, &axes, &known, effort, &observer).map_err(LogRefused::from)
            }
        }
    };
    let answer = answer.map_err(|error| arguments.log.refused(&log, &error))?;
    print(diagnose_text::answer_text(&log, &answer))?;
    if let (Some(path), Some(model)) = (&arguments.extended, &model) {
        let extended = extended_model(model, &answer.findings).map_err(bad_input)?;
        write_file(path, extended.to_toml().as_bytes())?;
        print(format!("extended model  {}\n", path.display()))?;
    }
    if let Some(path) = &arguments.experiment {
        match answer.experiment.as_ref().and_then(|experiment| experiment.scenario.as_ref()) {
            Some(scenario) => {
                write_file(path, scenario.to_script().as_bytes())?;
                print(format!("experiment      {}\n", path.display()))?;
            }
            None => print("experiment      none: no effects to separate, or no flight that would\n")?,
        }
    }
    if let Some(path) = &arguments.report {
        let page = diagnose_report::page(&log, &answer, &arguments.command());
        let page = if chosen.said.is_empty() { page } else { page.lead(&chosen.said) };
        write_file(path, page.to_html().as_bytes())?;
        print(format!("report          {}\n", path.display()))?;
    }
    write_json(arguments.json.as_deref(), &answer)?;
    arguments.judged(answer.verdict)
}
