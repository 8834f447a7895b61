//! What came of a fault, and the table of all.

use std::fmt::Write;
use std::path::PathBuf;

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Flight, MILLISECOND};
use shared_control::log_card::CardError;

use crate::rows::{End, Row};

/// What MAIN may carry: the disarmed pulse.
const MAIN_MAX_US: u16 = 1000;
/// Nothing that flies on ends beyond this: the test sequence and the rows' sticks hold up to 30 degrees.
const UPRIGHT_DEG: f64 = 40.0;
/// Above every idle command, below every flight's.
const IDLE_COMMAND_MAX: f64 = 0.16;

/// Set to write `FAULTS.md` anew.
const RENEW: &str = "RENEW_BOARD_FIGURES";

const HEAD: &str = "\
# Faults in flight, and what came of each

The firmware's own image flies the test sequence on the emulated board, or by the radio's sticks where the row says so.
Half a second into it, right after a step of the loop, a fault is injected; in free flight two metres up, in hover. The
table shows what the motor outputs then do and what the vehicle reports to the ground.
`cargo xtask board-test` injects them all again, fails where a promise is broken, and compares this table;
`RENEW_BOARD_FIGURES=1 cargo xtask board-test` writes it.

Outputs are those that last: *fly on* is as before the fault, *idle* is armed on the rig with all motors at idle,
*disarmed* is the shortest pulse, at which no motor turns, *none* is no pulse at all. *Within* bounds the end of the
last pulse at which a motor turns; *found* is the measured end, rounded up. *Longest pulse* is that of an AUX line
behind the level shifter, from the fault on: 2 ms at most are promised, over resets too. No flight is cut short by the
resets themselves: the board comes back disarmed, half a second to a second later, and without a pulse until then.

| fault | outputs | within | found | longest pulse | resets | reported to the ground |
|---|---|---|---|---|---|---|
";

/// A row and what was found.
pub struct Outcome {
    pub row: &'static Row,
    end: End,
    live_ms: Option<u64>,
    longest_us: u64,
    resets: u64,
    cut: bool,
    /// Longest pulse on MAIN at the end, us.
    main_us: u16,
    overruns: u32,
    tilt_deg: f64,
    /// At the end.
    end_tilt_deg: f64,
    reports: Vec<String>,
}

impl Outcome {
    /// Injects into a flight that has come to where the fault meets it, watches.
    pub fn of(row: &'static Row, mut flight: Flight) -> Self {
        let (fault_at, heard, resets) =
            (flight.machine.now(), flight.ground.texts().len(), flight.machine.counters().resets);
        flight.vehicle.borrow_mut().record_pulses();
        (row.inject)(&mut flight);
        let rest = (fault_at + row.watch_ms * MILLISECOND).saturating_sub(flight.machine.now());
        flight.run_for(rest);
        let (now, overruns) = (flight.machine.now(), flight.counter("LOOP_OVERRUNS"));
        let tilt_deg = flight.largest_tilt_deg();
        let end_tilt_deg = flight.tilt_deg().into_iter().fold(0.0, |most: f64, tilt| most.max(tilt.abs()));
        let still_high = flight.machine.aux_high_since().into_iter().flatten().map(|since| now - since);
        let vehicle = flight.vehicle.borrow();
        let ended = vehicle.line_pulses().iter().filter(|pulse| pulse.rise + pulse.width > fault_at);
        let longest = ended.map(|pulse| pulse.width).chain(still_high).max().unwrap_or(0);
        let pulses = vehicle.pulses();
        // a pulse a step, and a step is at most 10 ms
        let recent = now - 20 * MILLISECOND;
        let end = match (pulses.last_live_end() > recent, pulses.last_end() > recent) {
            (true, _) if vehicle.commands().iter().all(|command| *command < IDLE_COMMAND_MAX) => End::Idle,
            (true, _) => End::FliesOn,
            (false, true) => End::Disarmed,
            (false, false) => End::NoPulses,
        };
        let live = pulses.last_live_end().saturating_sub(fault_at);
        let live_ms = matches!(end, End::Disarmed | End::NoPulses).then_some(live.div_ceil(MILLISECOND));
        // the slot is empty in all of them, which is no fault's doing
        let of_fault = flight.ground.texts()[heard..].iter().filter(|(_, text)| text != CardError::Absent.words());
        let mut reports = of_fault.map(|(_, text)| without_addresses(text)).collect::<Vec<_>>();
        reports.dedup();
        let resets = flight.machine.counters().resets - resets;
        let longest_us = longest / TICKS_PER_US;
        let main_us = flight.machine.main_outputs_us().into_iter().max().unwrap_or(0);
        let cut = pulses.cut();
        Self { row, end, live_ms, longest_us, resets, cut, main_us, overruns, tilt_deg, end_tilt_deg, reports }
    }

    /// What differs from the promise.
    pub fn broken_promise(&self) -> Option<String> {
        let Row { fault, end, within_ms, says, longest_us, .. } = self.row;
        let late = self.live_ms.is_some_and(|live_ms| live_ms > *within_ms);
        let missing = says.iter().find(|words| !self.reports.iter().any(|report| report.contains(**words)));
        // nothing tips the vehicle over while it flies, and no step takes longer than its period
        let disturbed = *end == End::FliesOn
            && (self.tilt_deg > self.row.tilt_max_deg || self.end_tilt_deg > UPRIGHT_DEG || self.overruns > 0);
        let wide = self.longest_us > *longest_us;
        let main_driven = self.main_us > MAIN_MAX_US;
        let wrong = main_driven
            || self.end != *end
            || late
            || wide
            || missing.is_some()
            || disturbed
            || self.cut && !self.row.may_cut;
        wrong.then(|| {
            let Self { end, live_ms, longest_us, cut, reports, .. } = self;
            format!(
                "{fault}: ends {end:?}, live for {live_ms:?} of {within_ms} ms, longest pulse {longest_us} us, \
                 cut {cut}, MAIN {} us, tilt {:.1} deg, at the end {:.1}, reports {reports:?}, missing {missing:?}",
                self.main_us, self.tilt_deg, self.end_tilt_deg
            )
        })
    }
}

/// Addresses and step numbers change with every build.
fn without_addresses(text: &str) -> String {
    let mut words: Vec<&str> = Vec::new();
    for word in text.split(' ') {
        let counts_steps = words.last() == Some(&"step");
        words.push(if word.starts_with("0x") || counts_steps { "..." } else { word });
    }
    words.join(" ")
}

pub fn markdown(outcomes: &[Outcome]) -> String {
    let mut text = HEAD.to_owned();
    for Outcome { row, live_ms, longest_us, resets, reports, .. } in outcomes {
        let outputs = match row.end {
            End::FliesOn => "fly on",
            End::Idle => "idle",
            End::Disarmed => "disarmed",
            End::NoPulses => "none",
        };
        let found = live_ms.map_or("-".to_owned(), |ms| format!("{ms} ms"));
        let within = live_ms.map_or("-".to_owned(), |_| format!("{} ms", row.within_ms));
        // to a tenth: another build samples at other microseconds
        let longest_ms = longest_us.div_ceil(100) as f64 / 10.0;
        let reports = if reports.is_empty() { "-".to_owned() } else { reports.join("; ") };
        // a board that goes on resetting does so until it is helped
        let resets = if *resets > 2 { "again and again".to_owned() } else { resets.to_string() };
        let _ = writeln!(
            text,
            "| {} | {outputs} | {within} | {found} | {longest_ms} ms | {resets} | {reports} |",
            row.fault
        );
    }
    text
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("FAULTS.md")
}

/// Writes it, if told to.
pub fn renew(text: &str) {
    if std::env::var_os(RENEW).is_some() {
        std::fs::write(path(), text).unwrap();
    }
}

/// Compares with what is committed.
pub fn compare(text: &str) {
    let committed = std::fs::read_to_string(path()).unwrap_or_default();
    assert!(committed == text, "FAULTS.md is not what was found; renew it: {RENEW}=1 cargo xtask board-test");
}
