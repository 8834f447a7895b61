//! The page: the four figures of chapter 5 and its table, why ours differ, what the text says, the constants.

use super::propulsion::{constants, contradictions, curves};
use super::{LEFT_OUT, fidelity, gains, reasons, verdict};
use crate::cosim::record::FlightRecord;
use crate::margins::Margins;
use crate::report::{Card, Cell, Chart, Page, Section, Table, Tone};
use crate::scenario::Scenario;
use crate::thesis::{Reproduction, Verdict, real_lag_s};

/// A page of its own.
pub fn page(of: &Reproduction, command: &str) -> Page {
    let confirmed = of.claims.iter().filter(|claim| claim.verdict == Verdict::Confirmed).count();
    let mut card = Card::new(Tone::Good);
    for row in fidelity(of).iter().filter(|row| row.printed_deg.is_some()) {
        let [_, printed] = row.printed_deg.unwrap_or([f64::NAN; 2]);
        let here = row.here.pitch_deg;
        card = card.line(row.controller.as_str(), format!("pitch deviates by {here:.2} degrees, printed {printed:.2}"));
    }
    card = card.line("What the text says", format!("{confirmed} of {} sentences hold here too", of.claims.len()));
    let page = Page::new("One ring off balance can explain both pitch deviations of the thesis")
        .about("The thesis' experiment flown again, chapters 3 to 5 and appendix C")
        .lead(
            "Its testbed is gone. In its place flies the simulated one with the ring's centre of gravity off the axis \
             and with noise in its sensors, under the thesis' MPC and under APM:Copter's cascade.",
        )
        .card(card);
    [table_5_1(of), why(of), integral(of), log_lateness(of), sequence()]
        .into_iter()
        .chain(figures(of))
        .chain([claims(of), horizons(of), constants(of), curves().folded(), contradictions().folded(), left_out()])
        .fold(page, Page::section)
        .provenance("Command", command)
        .provenance("Version", env!("CARGO_PKG_VERSION"))
}

fn table_5_1(of: &Reproduction) -> Section {
    let mut table = Table::new(
        "Mean deviation of the simulation from the test, degrees",
        &["controller", "roll, printed", "roll, here", "pitch, printed", "pitch, here"],
    );
    for row in fidelity(of) {
        let printed = |axis: usize| Cell::number(row.printed_deg.map_or(f64::NAN, |degrees| degrees[axis]), 2);
        let here = [row.here.roll_deg, row.here.pitch_deg].map(|degrees| Cell::number(degrees, 2));
        let [roll, pitch] = here;
        table = table.row([row.controller.clone().into(), printed(0), roll, printed(1), pitch]);
    }
    Section::new("Table 5.1").table(table).note("At 10 rows per second, as the thesis' log.")
}

fn why(of: &Reproduction) -> Section {
    let lines = reasons(of).map(|(heading, explanation)| format!("{heading}: {explanation}"));
    Section::new("Why ours differ").list(lines)
}

fn integral(of: &Reproduction) -> Section {
    let factors: Vec<f64> = of.copter_rows.iter().map(|row| row.rate_factor).collect();
    let limited: Vec<f64> = of.copter_rows.iter().map(|row| row.limited.pitch_deg).collect();
    let unlimited: Vec<f64> = of.copter_rows.iter().map(|row| row.unlimited.pitch_deg).collect();
    let [_, printed] = crate::thesis::printed::TABLE_5_1_PID_DEG;
    let chart = Chart::over("factor on the rate gains", "pitch under Copter's cascade", "deg")
        .series("integral ends at 1000 of 4500", &factors, &limited)
        .series("no such end", &factors, &unlimited)
        .step_series("printed", &factors, &vec![printed; factors.len()])
        .value_range(0.0, 15.0);
    Section::new("The PID's 5.80 degrees")
        .paragraph(
            "Mean deviation of pitch under the same ring, over the factor on Copter's default rate gains: with the end \
             of the integral that Copter has by default, and without one.",
        )
        .chart(chart)
}

fn log_lateness(of: &Reproduction) -> Section {
    let mut table = Table::new(
        "Deviations if the test's log begins late, degrees",
        &["late, s", "MPC roll", "MPC pitch", "cascade roll", "cascade pitch"],
    );
    for row in &of.late {
        let deviations =
            [row.thesis_mpc.roll_deg, row.thesis_mpc.pitch_deg, row.cascade.roll_deg, row.cascade.pitch_deg];
        let cells = [Cell::number(row.late_s, 2)].into_iter();
        table = table.row(cells.chain(deviations.map(|degrees| Cell::number(degrees, 2))));
    }
    Section::new("What a log's time does").table(table)
}

fn degrees(rad: &[f64]) -> Vec<f64> {
    rad.iter().map(|angle| angle.to_degrees()).collect()
}

fn sequence() -> Section {
    let positions = |axis: fn(&crate::scenario::Waypoint) -> f64| -> Vec<f64> {
        Scenario::test_sequence().waypoints.iter().map(axis).collect()
    };
    let (roll, pitch) = (positions(|of| of.roll_rad), positions(|of| of.pitch_rad));
    let chart =
        Chart::over("roll, deg", "positions", "pitch, deg").points("position", &degrees(&roll), &degrees(&pitch));
    Section::new("Figure 5.2: the test sequence")
        .paragraph(
            "Nine positions, a hover between any two; each is held for 1.75 s, which is this project's choice: the \
             thesis gives no times.",
        )
        .chart(chart)
        .folded()
}

/// Figures 5.3 to 5.6.
fn figures(of: &Reproduction) -> [Section; 4] {
    let pid = format!("APM:Copter's cascade with {}", gains(of));
    let (mpc, copter) = (&of.mpc, &of.copter);
    [
        figure("Figure 5.3: MPC, simulated and tested", "", [("simulated", &mpc.simulated), ("tested", &mpc.tested)]),
        figure(
            "Figure 5.4: PID, simulated and tested",
            &pid,
            [("simulated", &copter.simulated), ("tested", &copter.tested)],
        ),
        figure("Figure 5.5: MPC and PID, simulated", &pid, [("MPC", &mpc.simulated), ("PID", &copter.simulated)]),
        figure("Figure 5.6: MPC and PID, tested", &pid, [("MPC", &mpc.tested), ("PID", &copter.tested)]),
    ]
}

fn figure(title: &str, paragraph: &str, flights: [(&str, &FlightRecord); 2]) -> Section {
    let charts = [(0, "Roll angle"), (1, "Pitch angle")].map(|(axis, name)| {
        let [(_, first), _] = flights;
        let reference = degrees(&first.reference_of(axis));
        let chart = Chart::time_series(name, "deg").step_series("reference", &first.time_s, &reference);
        flights
            .into_iter()
            .fold(chart, |chart, (name, record)| chart.series(name, &record.time_s, &degrees(&record.angle_of(axis))))
    });
    let section = Section::new(title);
    let section = if paragraph.is_empty() { section } else { section.paragraph(format!("PID: {paragraph}.")) };
    charts.into_iter().fold(section, Section::chart)
}

fn claims(of: &Reproduction) -> Section {
    let mut table = Table::new("Sentences of chapters 4 and 5", &["section", "it says", "here too", "what we find"]);
    for claim in &of.claims {
        table = table.row([claim.section, claim.says, verdict(claim.verdict), claim.found.as_str()].map(Cell::from));
    }
    Section::new("What the text says").table(table)
}

fn horizons(of: &Reproduction) -> Section {
    let lag_ms = 1e3 * real_lag_s();
    let mut table = Table::new(
        format!("The thesis' MPC by its prediction horizon; at the right with motors that lag by {lag_ms:.0} ms"),
        &[
            "steps",
            "largest pitch, deg",
            "delay margin, ms",
            "peak sensitivity",
            "delay margin, ms",
            "peak sensitivity",
        ],
    );
    for row in &of.horizons {
        let of_row = [Cell::from(row.horizon.to_string()), Cell::number(row.pitch_max_deg, 1)];
        let margins = [&row.margins, &row.margins_with_lag].into_iter().flat_map(pitch_cells);
        table = table.row(of_row.into_iter().chain(margins));
    }
    Section::new("Section 4.4: how far ahead it must look")
        .paragraph(
            "The thesis found a horizon of 20 steps unstable on its rig. On its own model it is not: the rotor inertia \
             of table C.3 is a tenth of a real one's, so that the modelled motors hardly lag. With the lag of a real \
             F450's motors, of which the controller does not know, 20 steps oscillate and 30 hold.",
        )
        .table(table)
        .note("Margins of pitch in hover; the test sequence asks for 30 degrees.")
}

fn pitch_cells(margins: &Option<[Margins; 2]>) -> [Cell; 2] {
    match margins {
        Some([_, pitch]) => {
            [Cell::number(pitch.delay_ms.unwrap_or(f64::NAN), 0), Cell::number(pitch.sensitivity_peak, 2)]
        }
        None => ["oscillates", "oscillates"].map(Cell::from),
    }
}

fn left_out() -> Section {
    Section::new("What is not made again").list(LEFT_OUT)
}
