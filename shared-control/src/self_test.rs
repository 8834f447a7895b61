//! The board's self-tests, by number: what somebody with a debug probe has it try before a propeller goes on. What is
//! measured is the board's; which test takes what of it, and what it must be, stands here.

use crate::elementary::sqrt;
use crate::io_chip::session::IoState;
use crate::link::VehicleStatus;

/// What the board has measured for a test, besides its status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured {
    /// Cycles of the core in a millisecond of the time base.
    pub cycles_per_ms: u32,
    /// Is the supply above the detector's 2.9 V?
    pub supply_is_good: bool,
    /// Does the parameters' memory hold a whole record?
    pub memory_is_whole: bool,
    /// Deepest stack so far, bytes.
    pub stack_used_bytes: u32,
}

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SelfTest {
    /// From 1 on.
    pub number: u32,
    /// What it is called.
    pub name: &'static str,
    /// What it shows when it passes.
    pub shows: &'static str,
    /// Of the figure.
    pub unit: &'static str,
    /// The least and the largest figure that passes.
    pub allowed: (i32, i32),
}

const fn test(
    number: u32,
    name: &'static str,
    shows: &'static str,
    unit: &'static str,
    allowed: (i32, i32),
) -> SelfTest {
    SelfTest { number, name, shows, unit, allowed }
}

/// 1 g, and what zero-g offsets of 80 mg and a seat that is not level leave of it (PS-MPU-6000A 6.2).
const GRAVITY_MM_S2: (i32, i32) = (8_800, 10_800);

/// All of them, in the order in which they are to be run.
pub const SELF_TESTS: [SelfTest; 10] = [
    test(1, "clock", "PLL and time base have the rates that all pulses are made with", "cycles/ms", (167_800, 168_200)),
    test(2, "supply", "the chip's supply is above 2.9 V", "good", (1, 1)),
    test(3, "memory", "the FRAM answers, and holds a whole record of parameters", "whole", (1, 1)),
    test(4, "first IMU", "the MPU6000 sends, and feels gravity at rest", "mm/s^2", GRAVITY_MM_S2),
    test(5, "second IMU", "L3GD20 and LSM303D send, and feel gravity at rest", "mm/s^2", GRAVITY_MM_S2),
    test(6, "IO chip", "the second processor answers, and its firmware is known", "known", (1, 1)),
    test(7, "battery", "the power module's voltage is measured", "mV", (6_000, 17_000)),
    test(8, "pulses", "all four outputs are given the disarmed pulse", "us", (1_000, 1_000)),
    test(9, "loop", "no step of the loop was late so far", "late steps", (0, 0)),
    test(10, "stack", "a quarter of the stack was never used", "bytes used", (1, 49_152)),
];

impl SelfTest {
    /// That of a number.
    pub fn by_number(number: u32) -> Option<&'static SelfTest> {
        SELF_TESTS.iter().find(|test| test.number == number)
    }

    /// What it finds; nothing where there is nothing to be found.
    pub fn figure(&self, measured: &Measured, status: &VehicleStatus) -> Option<i32> {
        match self.number {
            1 => i32::try_from(measured.cycles_per_ms).ok(),
            2 => Some(measured.supply_is_good.into()),
            3 => Some(measured.memory_is_whole.into()),
            4 => rest_force_mm_s2(status, 0),
            5 => rest_force_mm_s2(status, 1),
            6 => Some(matches!(status.io.state, IoState::Known(_)).into()),
            7 => status.battery_v.map(|volts| (volts * 1000.0) as i32),
            8 => {
                let [first, others @ ..] = status.pulses_us;
                others.iter().all(|pulse_us| *pulse_us == first).then_some(first.into())
            }
            9 => i32::try_from(status.overruns).ok(),
            10 => i32::try_from(measured.stack_used_bytes).ok(),
            _ => None,
        }
    }

    /// Is that as it must be?
    pub fn passes(&self, figure: Option<i32>) -> bool {
        let (least, most) = self.allowed;
        figure.is_some_and(|figure| least <= figure && figure <= most)
    }
}

/// Of an IMU at rest; none where it sends nothing, or is moved.
fn rest_force_mm_s2(status: &VehicleStatus, imu: usize) -> Option<i32> {
    let force_m_s2 = status.rest_force_m_s2.get(imu).copied().flatten()?;
    Some((1000.0 * sqrt(force_m_s2.norm_squared())) as i32)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::config::Controller;
    use nalgebra::Vector3;
    use std::vec::Vec;

    fn good() -> (Measured, VehicleStatus) {
        let measured =
            Measured { cycles_per_ms: 168_001, supply_is_good: true, memory_is_whole: true, stack_used_bytes: 9_000 };
        let rest_force_m_s2 = [Some(Vector3::new(0.3, 0.2, -9.8)); 2];
        let status = VehicleStatus {
            rest_force_m_s2,
            pulses_us: [1000; 4],
            battery_v: Some(12.4),
            ..VehicleStatus::at_start(Controller::Cascade)
        };
        (measured, status)
    }

    fn failed(measured: &Measured, status: &VehicleStatus) -> Vec<u32> {
        SELF_TESTS.iter().filter(|test| !test.passes(test.figure(measured, status))).map(|test| test.number).collect()
    }

    #[test]
    fn numbers_go_up_from_one_and_each_has_a_figure() {
        assert!(SELF_TESTS.iter().zip(1..).all(|(test, number)| test.number == number));
        assert!(SELF_TESTS.iter().all(|test| SelfTest::by_number(test.number) == Some(test)));
        assert!(SelfTest::by_number(0).is_none() && SelfTest::by_number(11).is_none());
        let (measured, status) = good();
        // nobody has asked the IO chip
        assert_eq!(failed(&measured, &status), [6]);
    }

    #[test]
    fn each_fails_alone_by_what_it_is_for() {
        let (good, healthy) = good();
        let fails = |measured: Measured, status: VehicleStatus| {
            failed(&measured, &status).into_iter().find(|number| *number != 6)
        };
        assert_eq!(fails(Measured { cycles_per_ms: 160_000, ..good }, healthy), Some(1));
        assert_eq!(fails(Measured { supply_is_good: false, ..good }, healthy), Some(2));
        assert_eq!(fails(Measured { memory_is_whole: false, ..good }, healthy), Some(3));
        let rest = |first, second| VehicleStatus { rest_force_m_s2: [first, second], ..healthy };
        let (gravity, half) = (healthy.rest_force_m_s2[0], Some(Vector3::new(0.0, 0.0, -4.9)));
        assert_eq!(fails(good, rest(None, gravity)), Some(4));
        assert_eq!(fails(good, rest(gravity, half)), Some(5));
        assert_eq!(fails(good, VehicleStatus { battery_v: None, ..healthy }), Some(7));
        assert_eq!(fails(good, VehicleStatus { pulses_us: [1000, 1000, 1100, 1000], ..healthy }), Some(8));
        assert_eq!(fails(good, VehicleStatus { overruns: 1, ..healthy }), Some(9));
        assert_eq!(fails(Measured { stack_used_bytes: 60_000, ..good }, healthy), Some(10));
    }
}
