//! A draft as a text: the map, TOML with a reason for each line, and above it what is not known or not used.

use super::Drafting;
use super::entry::Entry;
use crate::axis::Axis;
use crate::log::quantity::Quantity;

impl Drafting<'_> {
    fn axes(&self) -> Vec<Axis> {
        let moves = |axis: &Axis| self.has(Quantity::Angle(*axis)) || self.has(Quantity::Rate(*axis));
        Axis::ALL.into_iter().filter(moves).collect()
    }

    /// The map, with what is still wrong of it.
    pub(super) fn toml(&self, problems: &[String]) -> String {
        let mut text = String::from("# A draft by sil map: check each line, above all those with \"not known\".\n");
        for remark in self.remarks.iter().map(|remark| remark.replace('\n', " ")) {
            text.push_str(&format!("# {remark}\n"));
        }
        for problem in problems {
            text.push_str(&format!("# STILL WRONG: {}\n", problem.replace('\n', "\n#   ")));
        }
        if !self.unused.is_empty() {
            text.push_str(&format!("# not used: {}\n", self.unused.join(", ")));
        }
        text.push_str(&self.beside());
        text.push_str(&self.not_known());
        let axes: Vec<String> = self.axes().iter().map(|axis| format!("\"{}\"", axis.name())).collect();
        text.push_str(&format!("description = \"drafted from {}\"\n", self.file.replace(['"', '\\'], "'")));
        text.push_str(&format!("frame = \"{}\"\naxes = [{}]\n", self.frame, axes.join(", ")));
        if self.frame_turn_deg != 0.0 {
            text.push_str(&format!(
                "frame_turn_deg = {}   # to axes in which the motors stand as an X\n",
                self.frame_turn_deg
            ));
        }
        if self.has_motors() {
            text.push_str("active_when = \"motor1 > 0\"   # put idle in place of 0 if the motors idle on the ground\n");
        } else if self.has(Quantity::Thrust) {
            text.push_str("active_when = \"thrust_cmd > 0\"\n");
        }
        text.push_str("\n[quantities]\n");
        let mut entries: Vec<&Entry> = self.entries.iter().collect();
        entries.sort_by_key(|entry| entry.quantity);
        text.extend(entries.into_iter().map(Entry::line));
        text
    }

    /// What stands beside the table whose rows are read.
    fn beside(&self) -> String {
        let Some((_, rows)) = self.of_another_table.first() else { return String::new() };
        let names: Vec<&str> = self.of_another_table.iter().map(|(name, _)| name.as_str()).collect();
        format!(
            "# not used, of another table, which ends after {rows} of {} rows and has other times (make it a file of \
             its own, or merge both by their times): {}\n",
            self.rows,
            names.join(", ")
        )
    }

    /// What nothing in such a log can tell.
    fn not_known(&self) -> String {
        let mut said = String::new();
        let has_gyro = Axis::ALL.iter().any(|axis| self.has(Quantity::Rate(*axis)));
        if has_gyro && !self.has(Quantity::Accel(Axis::Yaw)) {
            said.push_str("# not known: the frame (no accelerometer): forward-right-down is taken\n");
        }
        for axis in self.axes() {
            let agrees = self.remarks.iter().any(|remark| remark.contains(axis.name()));
            if !agrees {
                let name = axis.name();
                said.push_str(&format!("# not known: the sign of {name} (too quiet, or nothing to hold it against)\n"));
            }
        }
        let has_reference = |axis: &&Axis| self.has(Quantity::Reference(**axis));
        if Axis::ALL.iter().any(|axis| has_reference(&axis)) {
            said.push_str("# not known: the references' signs; they are taken as the angles' are named\n");
        }
        said
    }
}
