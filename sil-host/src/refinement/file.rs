//! The model file of a refinement: what `--model` reads, each measured number with its interval and its source.

use std::fmt::Write;

use super::choice::Comparison;
use super::component::Component;
use super::constant::{Constant, ROTOR_INERTIA};
use super::form::Fitted;
use super::refined::Refined;

impl Refined {
    /// The model as text that reads back unchanged, with a remark on each constant of the propulsion.
    pub fn to_toml(&self) -> String {
        let mut sources: Vec<&str> = self.constants.iter().map(|constant| constant.source.as_str()).collect();
        sources.sort_unstable();
        sources.dedup();
        let mut text = format!(
            "# Written by sil refine. Base: \"{}\"; what a remark gives an interval was measured, 95 of 100 such \
             benches\n# have the truth within it. All else is the base's.\n",
            self.base
        );
        for source in sources {
            let _ = writeln!(text, "# Source: {source}");
        }
        for check in self.checks.iter().filter(|check| check.found == super::Found::Impossible) {
            let _ = writeln!(text, "# CAN'T BE: {}: {}", check.name, check.says);
        }
        text.push('\n');
        let mut table = String::new();
        for line in self.model.to_toml().lines() {
            if line.starts_with('[') {
                table = line.trim_matches(['[', ']']).to_owned();
            }
            text.push_str(line);
            if let Some(remark) = line.split_once(" = ").and_then(|(key, _)| self.remark(&table, key)) {
                let _ = write!(text, "   # {remark}");
            }
            text.push('\n');
        }
        text
    }

    fn remark(&self, table: &str, key: &str) -> Option<String> {
        let has_table = table.starts_with("propulsion.");
        if !has_table {
            return None;
        }
        if matches!((table, key), ("propulsion.esc", "command") | ("propulsion.rotor.lift_table", "speed_rad_s")) {
            let component = if table == "propulsion.esc" { Component::SpeedController } else { Component::Lift };
            return self.comparisons.iter().find(|of| of.component == component).map(Comparison::of_table);
        }
        let wanted = if table == "propulsion.rotor" && key == "inertia_kg_m2" { ROTOR_INERTIA } else { key };
        let measured = self.constants.iter().find(|constant| constant.key == wanted);
        match measured {
            Some(constant) if constant.key == ROTOR_INERTIA => {
                Some(format!("{}, by the lag with which the motor speeds up", constant.in_words()))
            }
            Some(constant) => Some(constant.in_words()),
            None if matches!(key, "map" | "voltage_v" | "lift_n") => None,
            None => Some(match (key, self.has(Component::SpeedController), self.has(Component::Motor)) {
                ("rate1", true, _) => "the map saturates: its first term stays".to_owned(),
                ("speed_offset_rad_s", _, true) => "the motor's line goes through the origin".to_owned(),
                _ => "the base's, not measured".to_owned(),
            }),
        }
    }

    fn has(&self, component: Component) -> bool {
        self.comparisons.iter().any(|comparison| comparison.component == component)
    }
}

impl Comparison {
    fn of_table(&self) -> String {
        let Fitted::Table(table) = &self.taken().fitted else { return String::new() };
        let [_, (_, unit)] = self.component.axes();
        format!(
            "{} points of {} readings; {:.3e} {unit} off where one is left out",
            table.points().len(),
            self.points.x.len(),
            self.taken().held_out
        )
    }
}

impl Constant {
    /// "0.127 ohm (0.126 to 0.128), 12 readings".
    pub fn in_words(&self) -> String {
        let [value, low, high] = [self.value, self.interval[0], self.interval[1]].map(|one| self.rounded(one));
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let outliers = match self.outliers {
            0 => String::new(),
            count => format!(", {count} of them outliers"),
        };
        format!("{value}{unit} ({low} to {high}), {} readings{outliers}", self.readings)
    }

    /// A number with two digits of the interval's half width, as 1.234e-5 where it is small.
    pub fn rounded(&self, number: f64) -> String {
        let half = 0.5 * (self.interval[1] - self.interval[0]);
        let least = if half > 0.0 { libm::floor(libm::log10(half)) as i32 - 1 } else { -6 };
        let largest = libm::floor(libm::log10(self.value.abs().max(1e-300))) as i32;
        if largest < -2 {
            let digits = (libm::floor(libm::log10(number.abs().max(1e-300))) as i32 - least).clamp(0, 8);
            format!("{number:.*e}", digits as usize)
        } else {
            format!("{number:.*}", (-least).clamp(0, 8) as usize)
        }
    }
}
