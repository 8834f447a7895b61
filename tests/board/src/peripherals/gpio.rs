//! General-purpose I/O. RM0090 section 8.4. Levels, functions, drive and speed of 16 pins.

use super::pin::{Drive, Speed};
use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

const MODE_OUTPUT: u32 = 1;
const MODE_ALTERNATE: u32 = 2;
const MODE_ANALOG: u32 = 3;
const PULL_UP: u32 = 1;
const PULL_DOWN: u32 = 2;

#[derive(Clone, Debug)]
pub(crate) struct Gpio {
    mode: u32,
    output_type: u32,
    speed: u32,
    pull: u32,
    output: u32,
    lock: u32,
    alternate: [u32; 2],
    /// What the board drives onto pins; the rest floats or is pulled.
    driven: u32,
    driven_level: u32,
}

impl Gpio {
    /// As after reset; ports A and B have debug pins (section 8.4.1).
    pub(crate) fn new(port: char) -> Self {
        let (mode, speed, pull) = match port {
            'A' => (0xa800_0000, 0x0c00_0000, 0x6400_0000),
            'B' => (0x0000_0280, 0x0000_00c0, 0x0000_0100),
            _ => (0, 0, 0),
        };
        let zero = Self {
            mode: 0,
            output_type: 0,
            speed: 0,
            pull: 0,
            output: 0,
            lock: 0,
            alternate: [0; 2],
            driven: 0,
            driven_level: 0,
        };
        Self { mode, speed, pull, ..zero }
    }

    fn mode_of(&self, pin: u32) -> u32 {
        self.mode >> (2 * pin) & 3
    }

    /// What the chip drives onto a pin as an output; none if it drives nothing.
    pub(crate) fn output_level(&self, pin: u32) -> Option<bool> {
        (self.mode_of(pin) == MODE_OUTPUT).then(|| self.output >> pin & 1 != 0)
    }

    /// What the chip does to the wire at a pin. A peripheral that has the pin gives `function` what it drives, `None`
    /// if it drives nothing. An open drain drives low only, a pull is what is left (sections 8.3.9 to 8.3.12).
    pub(crate) fn drive(&self, pin: u32, function: Option<bool>) -> Drive {
        let wanted = match self.mode_of(pin) {
            MODE_OUTPUT => Some(self.output >> pin & 1 != 0),
            MODE_ALTERNATE => function,
            _ => None,
        };
        let open_drain = self.output_type >> pin & 1 != 0;
        match (wanted, self.pull_of(pin)) {
            (Some(level), _) if !(level && open_drain) => Drive::Strong(level),
            // an analog pin has no pulls
            _ if self.is_analog(pin) => Drive::None,
            (_, PULL_UP) => Drive::Weak(true),
            (_, PULL_DOWN) => Drive::Weak(false),
            _ => Drive::None,
        }
    }

    fn pull_of(&self, pin: u32) -> u32 {
        self.pull >> (2 * pin) & 3
    }

    /// How fast its edges are.
    pub(crate) fn speed(&self, pin: u32) -> Speed {
        Speed::from_bits(self.speed >> (2 * pin))
    }

    /// The alternate function that has the pin.
    pub(crate) fn alternate_function(&self, pin: u32) -> Option<u32> {
        let function = self.alternate[(pin / 8) as usize] >> (4 * (pin % 8)) & 0xf;
        (self.mode_of(pin) == MODE_ALTERNATE).then_some(function)
    }

    /// Is the pin an analog one?
    pub(crate) fn is_analog(&self, pin: u32) -> bool {
        self.mode_of(pin) == MODE_ANALOG
    }

    /// Something outside the chip drives a pin.
    pub(crate) fn put(&mut self, pin: u32, high: bool) {
        self.driven |= 1 << pin;
        self.driven_level = if high { self.driven_level | 1 << pin } else { self.driven_level & !(1 << pin) };
    }

    /// The level at a pin.
    pub(crate) fn level(&self, pin: u32) -> bool {
        if let Some(level) = self.output_level(pin) {
            return level;
        }
        if self.driven >> pin & 1 != 0 { self.driven_level >> pin & 1 != 0 } else { self.pull_of(pin) == PULL_UP }
    }
}

impl Peripheral for Gpio {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        Ok(match offset {
            0x00 => self.mode,
            0x04 => self.output_type,
            0x08 => self.speed,
            0x0c => self.pull,
            0x10 => (0..16).filter(|pin| self.level(*pin)).fold(0, |levels, pin| levels | 1 << pin),
            0x14 => self.output,
            0x18 => 0,
            0x1c => self.lock,
            0x20 => self.alternate[0],
            0x24 => self.alternate[1],
            _ => return Err(Unmodelled("GPIO register")),
        })
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x00 => self.mode = value,
            0x04 => self.output_type = value,
            0x08 => self.speed = value,
            0x0c => self.pull = value,
            0x14 => self.output = value & 0xffff,
            // setting wins over resetting
            0x18 => self.output = self.output & !(value >> 16) | value & 0xffff,
            0x1c => return Err(Unmodelled("GPIO lock")),
            0x20 => self.alternate[0] = value,
            0x24 => self.alternate[1] = value,
            _ => return Err(Unmodelled("GPIO register")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_what_drives_it() {
        let mut port = Gpio::new('D');
        assert!(!port.level(15));
        port.write(0x0c, 1 << 30, 0).unwrap();
        assert!(port.level(15));
        port.put(15, false);
        assert!(!port.level(15));
        port.write(0x00, 1 << 30, 0).unwrap();
        port.write(0x18, 1 << 15, 0).unwrap();
        assert_eq!(port.read(0x10, 0).unwrap(), 1 << 15);
        port.write(0x18, 1 << 31, 0).unwrap();
        assert_eq!(port.output_level(15), Some(false));
    }

    #[test]
    fn a_pin_lets_go_at_reset_and_drives_as_it_is_told() {
        let mut port = Gpio::new('E');
        assert_eq!(port.drive(14, None), Drive::None);
        for (pull, drive) in [(1, Drive::Weak(true)), (2, Drive::Weak(false))] {
            port.write(0x0c, pull << 28, 0).unwrap();
            assert_eq!(port.drive(14, None), drive);
        }
        // a timer that has the pin, and one that has it but drives nothing
        port.write(0x00, 2 << 28, 0).unwrap();
        assert_eq!(port.drive(14, Some(true)), Drive::Strong(true));
        assert_eq!(port.drive(14, None), Drive::Weak(false));
        port.write(0x00, 1 << 28, 0).unwrap();
        assert_eq!(port.drive(14, None), Drive::Strong(false));
        port.write(0x00, 3 << 28, 0).unwrap();
        assert_eq!(port.drive(14, None), Drive::None);
    }

    #[test]
    fn an_open_drain_pulls_down_only() {
        let mut port = Gpio::new('E');
        port.write(0x00, 1 << 24, 0).unwrap();
        port.write(0x04, 1 << 12, 0).unwrap();
        assert_eq!(port.drive(12, None), Drive::Strong(false));
        port.write(0x18, 1 << 12, 0).unwrap();
        assert_eq!(port.drive(12, None), Drive::None);
    }

    #[test]
    fn speeds_are_two_bits_a_pin() {
        let mut port = Gpio::new('B');
        assert_eq!(port.speed(13), Speed::Low);
        port.write(0x08, 2 << 26, 0).unwrap();
        assert_eq!(port.speed(13), Speed::High);
    }

    #[test]
    fn a_function_needs_mode_and_number() {
        let mut port = Gpio::new('E');
        port.write(0x24, 1 << 24, 0).unwrap();
        assert_eq!(port.alternate_function(14), None);
        port.write(0x00, 2 << 28, 0).unwrap();
        assert_eq!(port.alternate_function(14), Some(1));
    }
}
