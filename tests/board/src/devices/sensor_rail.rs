//! The sensors' 3.3 V rail: switched by PE3, with a bleed of 220 Ohm (R621), and fed back by whatever the chip drives
//! high into the unpowered sensors. Pixhawk schematic PX4FMUv2.4.6; MPU-6000 product specification PS-MPU-6000A,
//! section 6.3 (supply ramp) and "Absolute Maximum Ratings"; STM32F427 data sheet, "Output voltage characteristics".
//!
//! Through a sensor's protection diode a line that is driven high lifts the rail to some 2.7 V: the sensors then never
//! lose their power, or start from half of it.

use crate::time::{TICKS_PER_S, Ticks};

const SUPPLY_V: f64 = 3.3;
const BLEED_OHM: f64 = 220.0;
const DIODE_V: f64 = 0.4;
/// Of a pin that drives high (data sheet: 0.4 V at 8 mA is 50 Ohm; two of three boards are better).
const PIN_OHM: f64 = 50.0;
/// A chip starts cleanly from less: its ramp is specified from 10 % of the supply on.
const CLEAN_BELOW_V: f64 = 0.33;

/// Said of a line that is high while the sensors have no supply.
pub const BACK_FED: &str =
    "a sensor's line is driven high while the sensors' supply is off (MPU-6000 PS, absolute maximum ratings)";
/// Said of PC13 to PC15, when that line is theirs.
pub const SOURCES_CURRENT: &str =
    "PC13 or PC15 feeds the unpowered sensors (STM32F427 data sheet, output voltage characteristics, note 1)";
/// Said of a supply that comes back before it had gone.
pub const RAMP_NOT_FROM_ZERO: &str =
    "the sensors' supply switched on before it had fallen (MPU-6000 PS section 6.3, supply ramp)";

/// Capacitors on the rail and in the sensors, uF: in no document that is at hand; tests take both ends.
pub(crate) const CAPACITANCE_UF: [f64; 2] = [5.0, 50.0];

#[derive(Clone, Debug)]
pub(crate) struct SensorRail {
    capacitance_uf: f64,
    on: bool,
    /// Lines that feed it while it is off.
    feeders: u32,
    /// What it had at this time.
    volts: f64,
    at: Ticks,
}

impl SensorRail {
    /// Without any power.
    pub(crate) fn new(capacitance_uf: f64) -> Self {
        Self { capacitance_uf, on: false, feeders: 0, volts: 0.0, at: 0 }
    }

    /// Its voltage now.
    pub(crate) fn volts(&self, now: Ticks) -> f64 {
        if self.on {
            return SUPPLY_V;
        }
        let elapsed_s = now.saturating_sub(self.at) as f64 / TICKS_PER_S as f64;
        let floor = self.fed_v();
        // fed through the pins it rises faster than the bleed lets it fall
        let ohm = if self.volts < floor { PIN_OHM / f64::from(self.feeders) } else { BLEED_OHM };
        let decay = (-elapsed_s / (ohm * self.capacitance_uf * 1e-6)).exp();
        floor + (self.volts - floor) * decay
    }

    /// Where the lines that feed it hold it.
    fn fed_v(&self) -> f64 {
        if self.feeders == 0 {
            return 0.0;
        }
        let source_ohm = PIN_OHM / f64::from(self.feeders);
        (SUPPLY_V - DIODE_V) * BLEED_OHM / (BLEED_OHM + source_ohm)
    }

    /// The switch, and how many lines are driven high into the sensors, from now on.
    ///
    /// # Errors
    /// If it is switched on before it has fallen: the sensors start in an unknown state.
    pub(crate) fn set(&mut self, on: bool, feeders: u32, now: Ticks) -> Result<(), &'static str> {
        let before = self.volts(now);
        let comes_on = on && !self.on;
        if on != self.on || feeders != self.feeders {
            (self.volts, self.at, self.on, self.feeders) = (before, now, on, feeders);
        }
        if comes_on && before > CLEAN_BELOW_V { Err(RAMP_NOT_FROM_ZERO) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLISECOND: Ticks = TICKS_PER_S / 1000;

    #[test]
    fn the_bleed_empties_it_within_26_ms_or_as_many_tenths() {
        // ln 10 time constants of 220 Ohm times the capacitance
        for (capacitance_uf, empty_ms) in [(5.0, 2.54), (50.0, 25.4)] {
            let mut rail = SensorRail::new(capacitance_uf);
            rail.set(true, 4, 0).unwrap();
            rail.set(false, 0, 0).unwrap();
            let at = |ms: f64| (ms * MILLISECOND as f64) as Ticks;
            assert!(rail.volts(at(empty_ms * 0.98)) > CLEAN_BELOW_V);
            assert!(rail.volts(at(empty_ms * 1.02)) < CLEAN_BELOW_V);
            assert_eq!(rail.clone().set(true, 0, at(empty_ms * 0.98)), Err(RAMP_NOT_FROM_ZERO));
            assert_eq!(rail.set(true, 0, at(empty_ms * 1.02)), Ok(()));
        }
    }

    #[test]
    fn selects_that_are_high_hold_it_up_for_ever() {
        for capacitance_uf in CAPACITANCE_UF {
            let mut rail = SensorRail::new(capacitance_uf);
            rail.set(true, 0, 0).unwrap();
            rail.set(false, 4, 0).unwrap();
            let later = rail.volts(TICKS_PER_S);
            assert!((2.5..2.9).contains(&later), "{later}");
            // let go, it falls
            rail.set(false, 0, TICKS_PER_S).unwrap();
            assert!(rail.volts(2 * TICKS_PER_S) < 0.01);
        }
    }

    #[test]
    fn one_line_lifts_a_rail_that_never_had_power() {
        for capacitance_uf in CAPACITANCE_UF {
            let mut rail = SensorRail::new(capacitance_uf);
            rail.set(false, 1, 0).unwrap();
            let lifted = rail.volts(20 * MILLISECOND);
            assert!((2.2..2.5).contains(&lifted), "{lifted}");
            assert_eq!(rail.set(true, 1, 20 * MILLISECOND), Err(RAMP_NOT_FROM_ZERO));
        }
    }
}
