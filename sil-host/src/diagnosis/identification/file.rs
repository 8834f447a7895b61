//! The model file of an identified vehicle: what `--model` reads, each number with its interval and where it is from.

use super::Identification;
use super::numbers::{Identified, LATENESS, manoeuvres_for};
use crate::effects::Effect;
use crate::vehicle::Mounting;

impl Identification {
    /// The model as text that reads back to the same numbers, with a remark on each.
    pub fn to_toml(&self) -> String {
        let mut text = self.head();
        let (mut table, mut effect) = (String::new(), 0);
        for line in self.model.to_toml().lines() {
            if line.starts_with('[') {
                table = line.to_owned();
                if line == "[[effect]]" {
                    text.push_str(&self.of_effect(effect));
                    effect += 1;
                }
            }
            let key = line.split(" = ").next().unwrap_or_default();
            text.push_str(line);
            if let Some(remark) = self.remark(&table, key) {
                text.push_str(&format!("   # {remark}"));
            }
            text.push('\n');
        }
        text
    }

    fn head(&self) -> String {
        let mut text = super::head(&self.source);
        if self.scale.mass_kg.is_none() || self.scale.arm_m.is_none() {
            text.push_str(
                "# A log shows ratios only: angular acceleration and lift over weight per command. What is set below\n\
                 # is a scale, with which forces, moments and inertias go; no prediction of a log depends on it. Give\n\
                 # it by --known mass_kg=... and --known arm_m=...\n",
            );
        }
        let [roll, pitch, yaw] = ["roll", "pitch", "yaw"].map(|axis| self.said(&format!("{axis}_effectiveness")));
        text.push_str(&format!(
            "# Angular acceleration per unit of one motor's command at base_command, mean of the motors:\n\
             #   roll {roll}\n#   pitch {pitch}\n#   yaw {yaw}\n"
        ));
        for motor in 1..=4 {
            let of =
                |axis: &str| self.number(&format!("motor{motor}_{axis}")).map_or(String::new(), |own| own.to_string());
            text.push_str(&format!(
                "#   motor {motor}: roll {}, pitch {}, yaw {}\n",
                of("roll"),
                of("pitch"),
                of("yaw")
            ));
        }
        if self.numbers.iter().any(|number| number.to_fly.is_some()) {
            text.push_str(
                "# What is marked \"not excited\" these logs hardly show: it is as usual vehicles have it where those\n\
                 # are alike, and else no more than its interval says.\n",
            );
        }
        for to_fly in manoeuvres_for(&self.numbers) {
            text.push_str(&format!("# To know what is marked \"not excited\": {to_fly}.\n"));
        }
        text + "\n"
    }

    /// What is known of a number, in words.
    fn said(&self, name: &str) -> String {
        self.numbers.iter().find(|number| number.name == name).map_or("not known".to_owned(), Identified::in_words)
    }

    fn remark(&self, table: &str, key: &str) -> Option<String> {
        let scale = |known: Option<f64>, without: &str| match known {
            Some(_) => "given (--known)".to_owned(),
            None => format!("NOT KNOWN: {without} is taken, as a scale"),
        };
        let Mounting::Free { mass_kg } = self.model.mounting else { return None };
        let of_scale = match (self.scale.mass_kg, self.scale.arm_m) {
            (Some(_), Some(_)) => "from the known mass and arm",
            _ => "with the scale",
        };
        Some(match (table, key) {
            ("", "arm_m") => scale(self.scale.arm_m, &format!("{} m", self.model.arm_m)),
            ("", "base_command") => "mean command of the motors in steady flight (median over windows)".to_owned(),
            ("", "gravity_m_s2") => "standard".to_owned(),
            ("[body]", "mass_kg") => scale(self.scale.mass_kg, &format!("{mass_kg} kg")),
            ("[body]", "ixx_kg_m2") => format!("{of_scale}; by roll's effectiveness"),
            ("[body]", "iyy_kg_m2") => {
                format!("{of_scale}; inertia of pitch over that of roll {}", self.said("pitch_inertia_over_roll"))
            }
            ("[body]", "izz_kg_m2") => {
                format!("expected: 0.88 of the sum of the other two; of that here {}", self.said("yaw_inertia"))
            }
            ("[propulsion]", "lift_slope_n") => {
                format!("{of_scale}; specific lift at base_command {}", self.said("hover_lift"))
            }
            ("[propulsion]", "lift_offset_n") => {
                format!("{of_scale}; {}; the bend is the effect thrust_curve", self.said("lift_at_no_command"))
            }
            ("[propulsion]", "reaction_torque_per_lift_m") => "by yaw's effectiveness and izz_kg_m2".to_owned(),
            ("[propulsion]", "battery_v") => {
                "median of the log, or the highest of several; at another one commands act by that ratio".to_owned()
            }
            ("[noise]", "gyro_rad_s" | "attitude_rad") => "the white part of the log's own".to_owned(),
            ("[noise]", "accel_m_s2") => "assumed".to_owned(),
            _ => return None,
        })
    }

    /// A line before an effect.
    fn of_effect(&self, index: usize) -> String {
        let Some(effect) = self.model.effects.get(index) else { return String::new() };
        let of_axis = |what: &str| effect.axis().map(|axis| self.said(&format!("{}_{what}", axis.name())));
        let said = match effect {
            Effect::ThrustCurve(_) => {
                Some(format!("share of the square in thrust over command {}", self.said("thrust_expo")))
            }
            Effect::WeakMotor(weak) => {
                Some(format!("lift over the mean of the motors {}", self.said(&format!("motor{}_lift", weak.motor))))
            }
            Effect::TorqueBias(_) => of_axis("trim").map(|trim| format!("trim, as an acceleration {trim}")),
            Effect::GyroBias(_) => of_axis("gyro_bias"),
            Effect::MotorLag(_) => {
                Some(format!("{}; lag and delay together {}", self.said("motor_lag_s"), self.said(LATENESS)))
            }
            Effect::ActuationDelay(_) => Some(self.said("delay_s")),
            _ => None,
        };
        said.map(|said| format!("# {said}\n")).unwrap_or_default()
    }
}

impl Identified {
    /// "0.052 s (0.049 to 0.055)"; "not excited" where the logs do not show it.
    pub fn in_words(&self) -> String {
        let digits = self.own.decimals().unwrap_or(6);
        let [low, high] = self.interval();
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let said = format!("{:.digits$}{unit} ({low:.digits$} to {high:.digits$})", self.own.value);
        match self.to_fly {
            Some(_) => format!("{said}, not excited"),
            None => said,
        }
    }
}
