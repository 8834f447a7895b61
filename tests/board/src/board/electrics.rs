//! Between the chip's pins and what is soldered to them: AUX lines, the sensors' rail, the rules that a pin can break.

use super::buses::{SPI1_PINS, SPI1_SELECTS, SPI2_PINS};
use super::wiring::MOTOR_PINS;
use super::{A, B, Board, C, E};
use crate::devices::aux_line::AuxLine;
use crate::devices::sensor_rail::{BACK_FED, SOURCES_CURRENT};
use crate::peripherals::pin::{Drive, Load};
use crate::peripherals::spi::Spi;
use crate::peripherals::spi_clock::{self, CLOCK_FLOATS};
use crate::peripherals::timer::Pulse;
use crate::rules::Broken;
use crate::stop::Cause;
use crate::time::Ticks;

/// TIM1's alternate function.
const TIM1_FUNCTION: Option<u32> = Some(1);
/// The sensors' supply, high is on.
const SENSORS_ON: u32 = 3;

impl Board {
    /// A document's rule is broken at this time: whether that is known and tolerated. Otherwise the run stops.
    pub(super) fn break_rule(&mut self, rule: &'static str, now: Ticks) -> bool {
        if !self.tolerated.contains(&rule) {
            self.refuse(Cause::Forbidden(rule), 0, None);
            return false;
        }
        match self.broken.iter_mut().find(|broken| broken.rule == rule) {
            Some(broken) => broken.times += 1,
            None => self.broken.push(Broken { rule, first: now, times: 1 }),
        }
        true
    }

    pub(super) fn keep_rule(&mut self, kept: Result<(), &'static str>, now: Ticks) {
        if let Err(rule) = kept {
            self.break_rule(rule, now);
        }
    }

    /// Follows the motor pins, by the timer's edges up to now and then by what the ports say.
    pub(super) fn refresh_aux(&mut self, now: Ticks) {
        let of_timer =
            |board: &Self, channel: usize| board.ports[E].alternate_function(MOTOR_PINS[channel]) == TIM1_FUNCTION;
        for edge in self.tim1.take_edges() {
            if of_timer(self, edge.channel) {
                let drive = self.ports[E].drive(MOTOR_PINS[edge.channel], edge.output);
                self.aux[edge.channel].drive(drive, edge.at);
            }
        }
        for (channel, pin) in MOTOR_PINS.into_iter().enumerate() {
            let function = self.tim1.output(channel).filter(|_| of_timer(self, channel));
            self.aux[channel].drive(self.ports[E].drive(pin, function), now);
            for (rise, width) in self.aux[channel].take_pulses() {
                self.world.line_pulse(Pulse { channel, rise, width });
            }
        }
    }

    pub(crate) fn tolerate(&mut self, rules: &[&'static str]) {
        self.tolerated = rules.to_vec();
    }

    pub(crate) fn set_load(&mut self, load: Load) {
        self.load = load;
    }

    pub(crate) fn set_lsi_hz(&mut self, lsi_hz: u64) {
        self.iwdg.set_lsi_hz(lsi_hz);
    }

    pub(crate) fn set_aux_floats_low(&mut self, duration: Ticks) {
        self.aux_floats_low = duration;
        self.aux = std::array::from_fn(|_| AuxLine::new(self.now, duration));
    }

    /// Since when each AUX line is high.
    pub(crate) fn aux_high_since(&mut self) -> [Option<Ticks>; 4] {
        let now = self.now;
        self.aux.each_mut().map(|line| line.high_since(now))
    }

    /// Switches the sensors' supply and sees who feeds it.
    pub(super) fn refresh_rail(&mut self, now: Ticks) {
        let on = self.ports[E].output_level(SENSORS_ON) == Some(true);
        let selects = SPI1_SELECTS.map(|(port, pin)| self.ports[port].drive(pin, None));
        let [clock, _, data] = SPI1_PINS;
        let bus = [self.ports[A].drive(clock, self.spi1.clock_output()), self.ports[A].drive(data, None)];
        let feeders = selects.into_iter().chain(bus).filter(|drive| *drive == Drive::Strong(true)).count() as u32;
        if (on, feeders) == self.rail_state {
            return;
        }
        let was_on = self.rail_state.0;
        self.rail_state = (on, feeders);
        if let Err(rule) = self.rail.set(on, feeders, now)
            && !self.break_rule(rule, now)
        {
            self.mpu6000.start_mut().come_up_badly(1);
        }
        if !on && feeders > 0 {
            let weak = [13, 15].into_iter().any(|pin| self.ports[C].drive(pin, None) == Drive::Strong(true));
            self.break_rule(BACK_FED, now);
            if weak {
                self.break_rule(SOURCES_CURRENT, now);
            }
        }
        if on != was_on {
            self.mpu6000.power(on, now);
            self.l3gd20.power(on, now);
            self.lsm303d.power(on, now);
        }
    }

    /// A device that is selected must see its clock at rest until the first byte.
    pub(super) fn check_idle_clocks(&mut self, now: Ticks) {
        let low = |board: &Self, (port, pin): (usize, u32)| board.ports[port].output_level(pin) == Some(false);
        let floats = |board: &Self, spi: &Spi, port: usize, pin: u32| {
            let drive = board.ports[port].drive(pin, spi.clock_output());
            // before that any level will do, as long as it is one
            if spi.is_configured() { !spi_clock::rests(drive, spi.idles_high()) } else { drive == Drive::None }
        };
        // without a supply nobody listens
        let (powered, _) = self.rail_state;
        let listens = powered && SPI1_SELECTS.into_iter().any(|select| low(self, select));
        let first = listens && floats(self, &self.spi1, A, SPI1_PINS[0]);
        let second = low(self, super::buses::FRAM) && floats(self, &self.spi2, B, SPI2_PINS[0]);
        if (first || second) && !std::mem::replace(&mut self.clock_floated, first || second) {
            self.break_rule(CLOCK_FLOATS, now);
        }
        self.clock_floated = first || second;
    }
}

#[cfg(test)]
mod tests;
