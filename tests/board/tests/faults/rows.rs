//! The faults, each with its promise.

use emulated_board::{Flight, MILLISECOND, Sensor, SensorFault};
use mavlink::dialects::common::MavCmd;
use shared_control::config::Controller;
use shared_control::params::radio::RadioParams;
use shared_control::params::vehicle::VehicleNumbers;
use shared_control::params::{Params, Rig};

/// How the outputs end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// As before the fault.
    FliesOn,
    /// Armed on the rig, all motors at idle.
    Idle,
    /// Shortest pulses.
    Disarmed,
    /// None.
    NoPulses,
}

/// A fault and what is promised.
pub struct Row {
    pub fault: &'static str,
    pub end: End,
    /// From the fault to the end of the last pulse that turns a motor, ms.
    pub within_ms: u64,
    /// Longest pulse that an ESC may see from the fault on, us.
    pub longest_us: u64,
    /// May a pulse be cut short? Only where hardware stops the processor or its clock.
    pub may_cut: bool,
    /// What the ground must hear.
    pub says: &'static [&'static str],
    pub mpc: bool,
    /// By the radio's sticks instead of the test sequence.
    pub radio: bool,
    /// Nothing holds the vehicle but the ground, on which it stands until it is lifted.
    pub free: bool,
    pub before: fn(&mut Flight),
    /// Half a second after it was let go: on the way to where the fault meets it.
    pub fly: fn(&mut Flight),
    pub inject: fn(&mut Flight),
    /// Largest roll or pitch while it flies on, degrees.
    pub tilt_max_deg: f64,
    /// For how long it is looked at, ms.
    pub watch_ms: u64,
}

/// A pulse may have begun when the last step was made: 0.5 ms of delay, and 2 ms at most.
pub const PULSE_MS: u64 = 3;
/// Five periods of the loop.
const DETECTION_MS: u64 = 13 + PULSE_MS;
/// The watchdog's longest, fed at most 10 ms before.
pub const WATCHDOG_MS: u64 = 55 + PULSE_MS;
/// From a reset to the loop, and as long again for the ground to hear of it.
pub const RESTART_MS: u64 = 3500;

/// Missing samples are bridged for 40 ms and a step of the loop.
pub const SILENCE_MS: u64 = 43 + PULSE_MS;

/// The link is given up after 3 s; the throttle stays for 2 s and falls to idle within 2 s; the vehicle counts as down
/// after 3 s at idle at most. A message takes its time, the loop its detection.
pub const LINK_LOST_MS: u64 = 3000 + 2000 + 2000 + 3000 + 200 + DETECTION_MS;
/// Longer than that.
pub const WATCH_LOST_LINK_MS: u64 = 10_500;

pub const NOTHING: Row = Row {
    fault: "",
    end: End::Disarmed,
    within_ms: DETECTION_MS,
    longest_us: FULL_THROTTLE_US,
    may_cut: false,
    says: &[],
    mpc: false,
    radio: false,
    free: false,
    before: |_| {},
    fly: |_| {},
    inject: |_| {},
    tilt_max_deg: 45.0,
    watch_ms: 600,
};

impl Row {
    pub fn params(&self) -> Params {
        let controller = if self.mpc { Controller::Mpc } else { Controller::Cascade };
        // a throttle that is found again in memory
        let radio = RadioParams { flies: self.radio, kill_channel: 5, ..RadioParams::DEFAULT };
        let (rig, hover_throttle_permille) =
            if self.free { (Rig::Free, FREE_HOVER_PERMILLE) } else { (Rig::Gimbal, HOVER_PERMILLE) };
        let vehicle = VehicleNumbers::F450;
        Params { controller, rig, hover_throttle_permille, radio, vehicle, ..Params::DEFAULT }
    }
}

/// What no ESC takes for more than it is, and no reset may add to.
const FULL_THROTTLE_US: u64 = 2000;

const HOVER_PERMILLE: u16 = 487;
/// Of the free F450.
const FREE_HOVER_PERMILLE: u16 = 540;

pub const ROWS: &[Row] = &[
    Row {
        fault: "IMU's data line dead, no second IMU",
        before: no_second_imu,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::DeadBus(0xff)),
        ..NOTHING
    },
    Row {
        fault: "IMU gone, no second IMU",
        within_ms: SILENCE_MS,
        before: no_second_imu,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff)),
        ..NOTHING
    },
    Row {
        fault: "IMU stuck, no second IMU",
        before: no_second_imu,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Frozen),
        ..NOTHING
    },
    Row {
        fault: "data-ready lost, no second IMU",
        within_ms: SILENCE_MS,
        before: no_second_imu,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::NoDataReady),
        ..NOTHING
    },
    Row {
        fault: "first IMU's data line dead, second fitted",
        end: End::FliesOn,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::DeadBus(0xff)),
        ..NOTHING
    },
    Row {
        fault: "first IMU gone, second fitted",
        end: End::FliesOn,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff)),
        ..NOTHING
    },
    Row {
        fault: "first IMU stuck, second fitted",
        end: End::FliesOn,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Frozen),
        ..NOTHING
    },
    Row {
        fault: "first IMU's data-ready lost, second fitted",
        end: End::FliesOn,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::NoDataReady),
        ..NOTHING
    },
    Row {
        // the link counts as lost for a few steps only, fewer than from one housekeeping to the next
        fault: "test sequence's set-point not a number (kept for 3 s: the last that was one; then down to idle)",
        end: End::Idle,
        says: &["link lost", "link back"],
        inject: spoil_setpoint,
        watch_ms: 6500,
        ..NOTHING
    },
    Row {
        fault: "nobody on TELEM1 any more",
        within_ms: LINK_LOST_MS,
        says: &["link lost", "disarmed: link lost"],
        inject: Flight::mute,
        watch_ms: WATCH_LOST_LINK_MS,
        ..NOTHING
    },
    Row {
        fault: "nobody on TELEM1 for 4 s, sticks flying",
        end: End::FliesOn,
        says: &["link lost", "link back"],
        inject: |flight| {
            flight.hold_throttle(500);
            flight.run_for(200 * MILLISECOND);
            flight.mute();
            flight.run_for(4000 * MILLISECOND);
            flight.unmute();
        },
        watch_ms: 6000,
        ..NOTHING
    },
    Row {
        fault: "nobody on TELEM1 for 4 s in the test sequence (which ends)",
        end: End::Idle,
        says: &["link lost", "link back"],
        inject: |flight| {
            flight.mute();
            flight.run_for(4000 * MILLISECOND);
            flight.unmute();
        },
        watch_ms: 7000,
        ..NOTHING
    },
    Row {
        fault: "a stick moves in the test sequence (which ends)",
        end: End::FliesOn,
        inject: |flight| flight.hold_throttle(450),
        watch_ms: 3000,
        ..NOTHING
    },
    Row {
        fault: "no samples for 10 ms, no second IMU",
        end: End::FliesOn,
        before: no_second_imu,
        inject: |flight| silence_imu(flight, 10),
        ..NOTHING
    },
    Row {
        fault: "no samples for 30 ms, no second IMU, twice",
        end: End::FliesOn,
        before: no_second_imu,
        inject: |flight| {
            silence_imu(flight, 30);
            // on the way to 30 degrees
            flight.run_for(1300 * MILLISECOND);
            silence_imu(flight, 30);
        },
        watch_ms: 2500,
        ..NOTHING
    },
    Row {
        fault: "TELEM1 flooded with noise at line rate, heartbeats among it",
        end: End::FliesOn,
        inject: |flight| flight.machine.telem1_flood(true),
        watch_ms: 2500,
        ..NOTHING
    },
    Row {
        fault: "TELEM1 flooded with messages at line rate",
        end: End::FliesOn,
        inject: flood_with_messages,
        watch_ms: 2000,
        ..NOTHING
    },
    Row {
        fault: "undefined instruction in the loop",
        within_ms: PULSE_MS,
        says: &["hard fault", "started by software reset"],
        inject: |flight| break_code(flight, LOOP, &UNDEFINED),
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "load from nowhere in housekeeping",
        within_ms: 10 + PULSE_MS,
        says: &["hard fault", "started by software reset"],
        inject: |flight| break_code(flight, HOUSEKEEPING, &LOAD_FROM_NOWHERE),
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "stack overflow",
        within_ms: PULSE_MS,
        says: &["hard fault", "started by software reset"],
        inject: overflow_stack,
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "loop hung",
        within_ms: WATCHDOG_MS,
        may_cut: true,
        says: &["started by watchdog"],
        inject: |flight| break_code(flight, LOOP, &BRANCH_TO_SELF),
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "housekeeping hung",
        within_ms: WATCHDOG_MS,
        may_cut: true,
        says: &["started by watchdog"],
        inject: |flight| break_code(flight, HOUSEKEEPING, &BRANCH_TO_SELF),
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "plan hung (MPC)",
        within_ms: WATCHDOG_MS,
        may_cut: true,
        says: &["started by watchdog"],
        mpc: true,
        inject: |flight| break_code(flight, PLAN, &BRANCH_TO_SELF),
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "supply down to 2.7 V for 20 ms",
        within_ms: PULSE_MS,
        says: &["low supply", "started by software reset"],
        inject: |flight| {
            flight.machine.set_supply_v(2.7);
            flight.run_for(20 * MILLISECOND);
            flight.machine.set_supply_v(3.3);
        },
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "crystal stops for good (the light shows it; the link has no clock)",
        end: End::NoPulses,
        within_ms: PULSE_MS,
        may_cut: true,
        inject: |flight| flight.machine.stop_crystal(),
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "crystal stops for 50 ms",
        within_ms: PULSE_MS,
        may_cut: true,
        says: &["crystal"],
        inject: |flight| {
            flight.machine.stop_crystal();
            flight.run_for(50 * MILLISECOND);
            flight.machine.mend_crystal();
        },
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "parameters corrupted (noticed at the next start, which then does not arm)",
        end: End::FliesOn,
        inject: |flight| flight.machine.write_fram(10, &[0xff; 4]),
        watch_ms: 500,
        ..NOTHING
    },
    Row {
        fault: "parameters corrupted, then restarted",
        within_ms: 200,
        says: &["configuration: damaged", "refused: configuration was bad"],
        inject: |flight| {
            flight.machine.write_fram(10, &[0xff; 4]);
            flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
            flight.run_for(100 * MILLISECOND);
            flight.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
            flight.run_for(2500 * MILLISECOND);
            flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        },
        watch_ms: RESTART_MS,
        ..NOTHING
    },
];

/// Handlers of the tasks, by the names of their interrupts.
pub const LOOP: &str = "TIM3";
const PLAN: &str = "CAN1_RX0";
pub const HOUSEKEEPING: &str = "CAN1_RX1";

/// `b .`
pub const BRANCH_TO_SELF: [u8; 2] = [0xfe, 0xe7];
/// `udf #0`
const UNDEFINED: [u8; 2] = [0x00, 0xde];
/// `mov.w r0, #0x90000000`, `ldr r0, [r0]`
const LOAD_FROM_NOWHERE: [u8; 6] = [0x4f, 0xf0, 0x10, 0x40, 0x00, 0x68];

/// On the board from the start.
pub fn no_second_imu(flight: &mut Flight) {
    flight.machine.break_sensor(Sensor::L3gd20, SensorFault::Removed(0xff));
    flight.machine.break_sensor(Sensor::Lsm303d, SensorFault::Removed(0xff));
}

/// On the board from the start.
pub fn no_first_imu(flight: &mut Flight) {
    flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff));
}

/// Other instructions at the start of a handler, until the board has reset itself.
pub fn break_code(flight: &mut Flight, handler: &str, instructions: &[u8]) {
    let address = flight.image.symbol(handler).expect("a handler") & !1;
    let good = flight.machine.bytes(address, instructions.len()).unwrap();
    let resets = flight.machine.counters().resets;
    flight.machine.poke(address, instructions);
    for _ in 0..200 {
        flight.run_for(MILLISECOND / 2);
        if flight.machine.counters().resets > resets {
            break;
        }
    }
    flight.machine.poke(address, &good);
}

/// The stack pointer goes where a deep recursion would have brought it.
fn overflow_stack(flight: &mut Flight) {
    let end = flight.image.symbol("_stack_end").expect("the stack's far end");
    while !flight.machine.is_asleep() {
        flight.run_for(MILLISECOND / 100);
    }
    flight.machine.poke_stack_pointer(end + 16);
}

/// The hover throttle, from which the image makes its set-points, becomes a NaN.
fn spoil_setpoint(flight: &mut Flight) {
    let control = flight.image.symbol_that_contains("local_resource_control").expect("the loop's memory");
    let throttle = (f32::from(HOVER_PERMILLE) / 1000.0).to_bits();
    let memory: Vec<u32> = (0..1280).map(|place| flight.machine.word(control + 4 * place).unwrap()).collect();
    // in a set-point it comes after three zeros while the vehicle hovers; those are left alone
    let kept = |place: &usize| memory[*place] == throttle && memory[place - 3..*place] != [0; 3];
    let places = (3..memory.len()).filter(kept).collect::<Vec<_>>();
    for place in places {
        flight.machine.poke(control + 4 * place as u32, &f32::NAN.to_bits().to_le_bytes());
    }
    flight.run_for(5 * MILLISECOND);
    assert!(f32::from_bits(flight.last().setpoint[3]).is_nan());
}

/// The first IMU's samples stay away for a while.
pub fn silence_imu(flight: &mut Flight, duration_ms: u64) {
    flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::NoDataReady);
    flight.run_for(duration_ms * MILLISECOND);
    flight.machine.mend_sensor(Sensor::Mpu6000);
}

/// Heartbeats back to back, for two seconds.
fn flood_with_messages(flight: &mut Flight) {
    // 21 bytes of 174 us each: 2.7 in 10 ms
    for _ in 0..190 {
        for _ in 0..3 {
            flight.ground.heartbeat(&mut flight.machine);
        }
        flight.run_for(10 * MILLISECOND);
    }
}
