//! The thesis on the terminal.

use super::{fidelity, reasons, verdict};
use crate::answer::text_table::TextTable;
use crate::thesis::Reproduction;

/// All of it.
pub fn text(of: &Reproduction) -> String {
    let mut text = "Table 5.1, mean deviation of the simulation from the test, degrees\n".to_owned();
    let mut table = TextTable::new(["controller", "roll printed", "here", "pitch printed", "here"]);
    for row in fidelity(of) {
        let printed = |axis: usize| row.printed_deg.map_or("-".to_owned(), |degrees| format!("{:.2}", degrees[axis]));
        let here = [row.here.roll_deg, row.here.pitch_deg].map(|degrees| format!("{degrees:.2}"));
        let [roll, pitch] = here;
        table.row([row.controller.clone(), printed(0), roll, printed(1), pitch]);
    }
    text.push_str(&format!("{table}\n"));
    for (heading, explanation) in reasons(of) {
        text.push_str(&format!("{heading}: {explanation}\n\n"));
    }
    text.push_str("What the text says\n");
    for claim in &of.claims {
        let answer = verdict(claim.verdict);
        text.push_str(&format!("  {:5}  {}\n         here: {answer}; {}\n", claim.section, claim.says, claim.found));
    }
    let same = of.constants.iter().filter(|constant| constant.testbed == constant.printed).count();
    text.push_str(&format!("\n{same} of {} printed constants are the testbed model's own\n", of.constants.len()));
    text
}
