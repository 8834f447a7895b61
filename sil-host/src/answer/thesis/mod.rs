//! The thesis flown again, as a person reads it: beside each printed number ours, and why it differs.

mod json;
mod page;
mod propulsion;
mod text;

pub use json::ThesisJson;
pub use page::page;
pub use text::text;

use crate::thesis::printed::{TABLE_5_1_MPC_DEG, TABLE_5_1_PID_DEG};
use crate::thesis::{Deviation, RING_MOMENT_NM, Reproduction, Verdict};

/// What cannot be made again here.
const LEFT_OUT: [&str; 3] = [
    "Figure 4.5 and the limit of 70 iterations: Midaco, a solver by ant colonies, is not free. The exact solver that \
     flies here has no such limit to choose.",
    "The measured points of figures C.2 to C.7 and the logs behind 5.3 to 5.6: the thesis prints neither. The curves \
     are drawn from the printed coefficients; the test is the simulated testbed with its ring off balance and noise in \
     its sensors.",
    "Photographs, drawings and block diagrams (3.1 to 3.9, 4.1 to 4.4). What they show stands in ARCHITECTURE.md and \
     docs/rig.md.",
];

/// A row of table 5.1 beside ours.
struct FidelityRow {
    controller: String,
    /// As printed, degrees; none where the thesis has no such controller.
    printed_deg: Option<[f64; 2]>,
    here: Deviation,
}

fn fidelity(of: &Reproduction) -> [FidelityRow; 3] {
    [
        FidelityRow {
            controller: "thesis' MPC, 100 Hz".to_owned(),
            printed_deg: Some(TABLE_5_1_MPC_DEG),
            here: of.mpc.deviation(0.0),
        },
        FidelityRow {
            controller: format!("APM:Copter's cascade, {}", gains(of)),
            printed_deg: Some(TABLE_5_1_PID_DEG),
            here: of.copter.deviation(0.0),
        },
        FidelityRow {
            controller: "this project's cascade, 400 Hz".to_owned(),
            printed_deg: None,
            here: of.cascade.deviation(0.0),
        },
    ]
}

fn gains(of: &Reproduction) -> String {
    of.rate_factor.map_or_else(
        || "default gains, 400 Hz".to_owned(),
        |factor| format!("rate gains {factor:.2} times the defaults, 400 Hz"),
    )
}

/// Why each number of table 5.1 is what it is: a heading and its explanation.
fn reasons(of: &Reproduction) -> [(&'static str, String); 3] {
    let [_, pid_pitch_deg] = TABLE_5_1_PID_DEG;
    let (held_nm, own_deg) = (of.integral_max_nm, of.cascade.deviation(0.0).pitch_deg);
    let without = of.copter_rows.iter().map(|row| row.unlimited.pitch_deg).fold(f64::NAN, f64::max);
    let factor = match of.rate_factor {
        Some(factor) => format!("With rate gains {factor:.2} times the defaults that is the printed deviation;"),
        None => "No factor on the gains that was tried gives the printed deviation;".to_owned(),
    };
    let late = of.late.iter().find(|row| row.late_s >= 0.1);
    let late = late.map_or_else(String::new, |row| {
        let (late_s, mpc_deg, pid_deg) = (row.late_s, row.thesis_mpc.roll_deg, row.cascade.roll_deg);
        format!(
            " If the test's log begins {late_s} s late, one of its rows, they differ by {mpc_deg:.2} and {pid_deg:.2}."
        )
    });
    [
        (
            "Pitch under the MPC",
            format!(
                "The ring's centre of gravity, as the thesis suspected: {RING_MOMENT_NM} N m, chosen so that this \
                 number comes out. From a log the diagnosis finds it to 0.1 % (docs/thesis-case.md)."
            ),
        ),
        (
            "Pitch under the PID",
            format!(
                "The same ring. An integral that may hold it does: this project's cascade deviates by {own_deg:.2} \
                 degrees. APM:Copter ends its integral at 1000 of 4500, which is {held_nm:.3} N m on these motors and \
                 less than the ring's moment; an angle has to hold the rest. {factor} without that limit no gains from \
                 the defaults upward make more than {without:.1} of the {pid_pitch_deg:.1} degrees. The thesis tuned \
                 by hand and prints neither gains nor limit: this explains the number, it does not prove it."
            ),
        ),
        (
            "Roll",
            format!(
                "Nothing is wrong with roll here, so two flights differ by their noise alone. The thesis lined up its \
                 log of 10 rows per second with the simulation.{late} Which share of the printed degrees that is, \
                 cannot be told: neither the logs nor the times of the test sequence are printed."
            ),
        ),
    ]
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Confirmed => "yes",
        Verdict::NotConfirmed => "no",
        Verdict::NotTried => "not tried",
    }
}
