//! Timers that count up: TIM1 (RM0090 section 17.4), TIM2, TIM3 and TIM5 (section 18.4). Time base with preload, PWM
//! mode 1, trigger output and slave modes reset and trigger. Nothing else of theirs is modelled.

use super::{Peripheral, Unmodelled};
use crate::time::{TICKS_PER_S, Ticks};

const CEN: u32 = 1;
const UDIS: u32 = 1 << 1;
const URS: u32 = 1 << 2;
const OPM: u32 = 1 << 3;
const ARPE: u32 = 1 << 7;
/// Direction, centre alignment, clock division.
const UNUSED_CONTROL: u32 = 0b111 << 4 | 0b11 << 8;

const UIF: u32 = 1;
const TIF: u32 = 1 << 6;
const UG: u32 = 1;
const MOE: u32 = 1 << 15;
/// With MOE at 0 the pins are held at their inactive level.
const OSSI: u32 = 1 << 10;
/// Dead time, lock, break: off.
const UNUSED_BREAK: u32 = 0xff | 0b11 << 8 | 1 << 12;

const CHANNELS: usize = 4;
const PWM_MODE_1: u32 = 6;
const TRGO_ENABLE: u32 = 1;
const TRGO_UPDATE: u32 = 2;
const SLAVE_RESET: u32 = 4;
const SLAVE_TRIGGER: u32 = 6;

/// A pulse that ended on a channel's pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulse {
    /// Channel, 0 to 3.
    pub channel: usize,
    /// Rising edge.
    pub rise: Ticks,
    /// From edge to edge.
    pub width: Ticks,
}

/// An output of TIM1 changed: none if the timer no longer drives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    pub(crate) channel: usize,
    pub(crate) at: Ticks,
    pub(crate) output: Option<bool>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Timer {
    advanced: bool,
    count_max: u32,
    cycle: Ticks,
    control: u32,
    control_2: u32,
    slave: u32,
    interrupts: u32,
    status: u32,
    mode: [u32; 2],
    enable: u32,
    brake: u32,
    prescaler: u32,
    reload: u32,
    compare: [u32; CHANNELS],
    active_prescaler: u32,
    active_reload: u32,
    active_compare: [u32; CHANNELS],
    /// When the counter was 0, or would have been at its clock of now: it may wrap. While stopped, `held` is the count.
    origin: Ticks,
    held: u32,
    matched: [bool; CHANNELS],
    high_since: [Option<Ticks>; CHANNELS],
    pulses: Vec<Pulse>,
    outputs: [Option<bool>; CHANNELS],
    edges: Vec<Edge>,
    triggers: Vec<Ticks>,
}

impl Timer {
    /// TIM1: 16 bits, with an output stage that MOE opens.
    pub(crate) fn advanced() -> Self {
        Self { advanced: true, ..Self::general(0xffff) }
    }

    /// TIM2 to TIM5, of this largest count.
    pub(crate) fn general(count_max: u32) -> Self {
        Self { count_max, reload: count_max, active_reload: count_max, ..Self::default() }
    }

    /// Period of its clock from now on. The counter goes on from where it is; what the prescaler had counted is lost.
    pub(crate) fn set_cycle(&mut self, cycle: Ticks, now: Ticks) {
        if cycle == self.cycle {
            return;
        }
        if self.cycle != 0 {
            self.tick(now);
        }
        let count = self.count(now);
        self.cycle = cycle;
        self.origin = now.wrapping_sub(self.step_ticks() * u64::from(count));
    }

    fn runs(&self) -> bool {
        self.control & CEN != 0
    }

    fn step_ticks(&self) -> Ticks {
        self.cycle * (u64::from(self.active_prescaler) + 1)
    }

    /// The counter.
    pub(crate) fn count(&self, now: Ticks) -> u32 {
        if !self.runs() {
            return self.held;
        }
        (now.wrapping_sub(self.origin) / self.step_ticks()).min(u64::from(self.active_reload)) as u32
    }

    fn next_update(&self) -> Option<Ticks> {
        (self.runs() && self.active_reload != 0)
            .then(|| self.origin.wrapping_add(self.step_ticks() * (u64::from(self.active_reload) + 1)))
    }

    fn next_match(&self, channel: usize) -> Option<Ticks> {
        let compare = self.active_compare[channel];
        let comes = self.runs() && !self.matched[channel] && compare <= self.active_reload;
        comes.then(|| self.origin.wrapping_add(self.step_ticks() * u64::from(compare)))
    }

    fn is_watched(&self, channel: usize) -> bool {
        self.interrupts >> (1 + channel) & 1 != 0 || self.high_since[channel].is_some()
    }

    fn is_pwm(&self, channel: usize) -> bool {
        let mode = self.mode[channel / 2] >> (8 * (channel % 2) + 4) & 7;
        self.enable >> (4 * channel) & 1 != 0 && mode == PWM_MODE_1
    }

    /// Frequency of the wave on a channel of a timer without main output enable; none if its pin stays at a level.
    pub(crate) fn wave_hz(&self, channel: usize) -> Option<f64> {
        let changes = (1..=self.active_reload).contains(&self.active_compare[channel]);
        let period = self.step_ticks() * (u64::from(self.active_reload) + 1);
        (self.runs() && self.is_pwm(channel) && changes).then(|| TICKS_PER_S as f64 / period as f64)
    }

    /// Does it drive the channel's pin? Not as long as CCxE is 0, nor while MOE is and OSSI too (table 97).
    fn drives(&self, channel: usize) -> bool {
        self.brake & (MOE | OSSI) != 0 && self.enable >> (4 * channel) & 1 != 0
    }

    /// What it drives onto a channel's pin now.
    pub(crate) fn output(&self, channel: usize) -> Option<bool> {
        self.outputs[channel]
    }

    /// Changes of the outputs since the last call.
    pub(crate) fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.edges)
    }

    fn output_level(&self, channel: usize, now: Ticks) -> bool {
        self.brake & MOE != 0 && self.is_pwm(channel) && self.count(now) < self.active_compare[channel]
    }

    /// Notes edges of the outputs, where somebody wants to know: at the motors.
    fn refresh_outputs(&mut self, now: Ticks) {
        if !self.advanced {
            return;
        }
        for channel in 0..CHANNELS {
            let output = self.drives(channel).then(|| self.output_level(channel, now));
            if self.outputs[channel] != output {
                self.outputs[channel] = output;
                self.edges.push(Edge { channel, at: now, output });
            }
            match (self.high_since[channel], self.output_level(channel, now)) {
                (None, true) => self.high_since[channel] = Some(now),
                (Some(rise), false) => {
                    self.high_since[channel] = None;
                    self.pulses.push(Pulse { channel, rise, width: now - rise });
                }
                _ => {}
            }
        }
    }

    /// Takes over what is preloaded and starts from 0 at `at`.
    fn update(&mut self, at: Ticks) {
        self.origin = at;
        self.held = 0;
        self.matched = [false; CHANNELS];
        if self.control & UDIS == 0 {
            self.active_prescaler = self.prescaler;
            self.active_reload = self.reload;
            self.active_compare = self.compare;
            self.trigger_output(TRGO_UPDATE, at);
        }
    }

    fn trigger_output(&mut self, event: u32, at: Ticks) {
        if self.control_2 >> 4 & 7 == event {
            self.triggers.push(at);
        }
    }

    fn overflow(&mut self, at: Ticks) {
        self.update(at);
        if self.control & UDIS == 0 {
            self.status |= UIF;
        }
        if self.control & OPM != 0 {
            self.control &= !CEN;
        }
    }

    /// UG, or the slave's reset.
    fn reinitialise(&mut self, now: Ticks) {
        self.update(now);
        if self.control & (UDIS | URS) == 0 {
            self.status |= UIF;
        }
    }

    fn start(&mut self, now: Ticks) {
        if !self.runs() {
            self.origin = now.wrapping_sub(self.step_ticks() * u64::from(self.held));
            self.control |= CEN;
            self.trigger_output(TRGO_ENABLE, now);
        }
    }

    /// The internal trigger input that its slave controller listens to, if it does.
    pub(crate) fn trigger_input(&self) -> Option<u32> {
        (self.slave & 7 != 0).then_some(self.slave >> 4 & 7)
    }

    /// Its master's trigger output pulsed.
    pub(crate) fn trigger(&mut self, now: Ticks) {
        self.tick(now);
        self.status |= TIF;
        match self.slave & 7 {
            SLAVE_RESET => self.reinitialise(now),
            SLAVE_TRIGGER => self.start(now),
            _ => {}
        }
        self.refresh_outputs(now);
    }

    /// Times at which the trigger output pulsed since the last call.
    pub(crate) fn take_triggers(&mut self) -> Vec<Ticks> {
        std::mem::take(&mut self.triggers)
    }

    /// The pins are let go of, as by a reset: pulses under way end here.
    pub(crate) fn cut_pulses(&mut self, now: Ticks) {
        for (channel, since) in self.high_since.iter_mut().enumerate() {
            let cut = since.take().map(|rise| Pulse { channel, rise, width: now.saturating_sub(rise) });
            self.pulses.extend(cut);
        }
    }

    /// Pulses that ended since the last call.
    pub(crate) fn take_pulses(&mut self) -> Vec<Pulse> {
        std::mem::take(&mut self.pulses)
    }

    pub(crate) fn update_interrupt(&self) -> bool {
        self.status & self.interrupts & UIF != 0
    }

    /// Compare and trigger interrupts.
    pub(crate) fn other_interrupts(&self) -> bool {
        self.status & self.interrupts & 0b101_1110 != 0
    }

    /// All of them on one line, as TIM2 to TIM5 have them.
    pub(crate) fn interrupt(&self) -> bool {
        self.update_interrupt() || self.other_interrupts()
    }

    fn write_control(&mut self, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        if value & UNUSED_CONTROL != 0 {
            return Err(Unmodelled("timer that does not simply count up"));
        }
        let held = self.count(now);
        let ran = self.runs();
        self.control = (value & !CEN) | (self.control & CEN);
        match (ran, value & CEN != 0) {
            (false, true) => self.start(now),
            (true, false) => {
                self.control &= !CEN;
                self.held = held;
            }
            _ => {}
        }
        Ok(())
    }

    fn write_compare(&mut self, channel: usize, value: u32, now: Ticks) {
        self.compare[channel] = value & self.count_max;
        let preloads = self.mode[channel / 2] >> (8 * (channel % 2) + 3) & 1 != 0;
        if !preloads {
            self.active_compare[channel] = self.compare[channel];
            // a value that the counter has passed matches in the next period only
            self.matched[channel] = self.count(now) > self.compare[channel];
        }
    }

    fn write_mode(&mut self, index: usize, value: u32) -> Result<(), Unmodelled> {
        // CCxS: inputs are not modelled
        if value & 0x303 != 0 {
            return Err(Unmodelled("timer input capture"));
        }
        self.mode[index] = value;
        Ok(())
    }

    fn write_slave(&mut self, value: u32) -> Result<(), Unmodelled> {
        if ![0, SLAVE_RESET, SLAVE_TRIGGER].contains(&(value & 7)) || value & 0xff08 != 0 {
            return Err(Unmodelled("timer slave mode other than reset or trigger"));
        }
        self.slave = value;
        Ok(())
    }
}

impl Peripheral for Timer {
    fn read(&mut self, offset: u32, now: Ticks) -> Result<u32, Unmodelled> {
        self.tick(now);
        Ok(match offset {
            0x00 => self.control,
            0x04 => self.control_2,
            0x08 => self.slave,
            0x0c => self.interrupts,
            0x10 => self.status,
            0x14 => 0,
            0x18 | 0x1c => self.mode[((offset - 0x18) / 4) as usize],
            0x20 => self.enable,
            0x24 => self.count(now),
            0x28 => self.prescaler,
            0x2c => self.reload,
            0x30 => 0,
            0x34..=0x40 => self.compare[((offset - 0x34) / 4) as usize],
            0x44 if self.advanced => self.brake,
            _ => return Err(Unmodelled("timer register")),
        })
    }

    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        self.tick(now);
        match offset {
            0x00 => self.write_control(value, now)?,
            0x04 => self.control_2 = value,
            0x08 => self.write_slave(value)?,
            0x0c if value & 0xff80 != 0 => return Err(Unmodelled("timer DMA or break interrupt")),
            0x0c => self.interrupts = value,
            0x10 => self.status &= value,
            0x14 if value & !UG != 0 => return Err(Unmodelled("timer event other than update")),
            0x14 if value & UG != 0 => self.reinitialise(now),
            0x14 => {}
            0x18 | 0x1c => self.write_mode(((offset - 0x18) / 4) as usize, value)?,
            // complementary outputs and inverted polarity
            0x20 if value & 0xeeee != 0 => return Err(Unmodelled("timer output other than active high")),
            0x20 => self.enable = value,
            0x24 => {
                self.held = value & self.count_max;
                self.origin = now.wrapping_sub(self.step_ticks() * u64::from(self.held));
            }
            0x28 => self.prescaler = value & 0xffff,
            0x2c => {
                self.reload = value & self.count_max;
                if self.control & ARPE == 0 {
                    self.active_reload = self.reload;
                }
            }
            0x30 if value == 0 => {}
            0x34..=0x40 => self.write_compare(((offset - 0x34) / 4) as usize, value, now),
            0x44 if self.advanced && value & UNUSED_BREAK == 0 => self.brake = value,
            _ => return Err(Unmodelled("timer register")),
        }
        self.refresh_outputs(now);
        Ok(())
    }

    fn tick(&mut self, now: Ticks) {
        // in the order of their times, or an output would be looked at before what came before
        loop {
            let matches = (0..CHANNELS).filter_map(|channel| Some((self.next_match(channel)?, Some(channel))));
            let update = self.next_update().map(|at| (at, None));
            let due = matches.chain(update).filter(|(at, _)| *at <= now).min_by_key(|(at, _)| *at);
            let Some((at, channel)) = due else { return };
            match channel {
                Some(channel) => {
                    self.matched[channel] = true;
                    self.status |= 2 << channel;
                }
                None => self.overflow(at),
            }
            self.refresh_outputs(at);
        }
    }

    fn next_event(&self) -> Option<Ticks> {
        // an update that nobody sees is caught up with later
        let updates_matter = self.advanced
            || self.interrupts & UIF != 0
            || self.control & OPM != 0
            || self.control_2 >> 4 & 7 == TRGO_UPDATE;
        let matches = (0..CHANNELS).filter(|channel| self.is_watched(*channel)).filter_map(|c| self.next_match(c));
        matches.chain(self.next_update().filter(|_| updates_matter)).min()
    }
}

#[cfg(test)]
mod tests;
