//! The findings: where each comes from and how it is looked at.

use std::panic::{AssertUnwindSafe, catch_unwind};

use emulated_board::rules::{self, Broken};
use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{
    EscMode, EscTraits, Flight, LSI_RANGE_HZ, Load, MILLISECOND, Mpu6000Revision, Pulse, Sensor, SensorFault,
};
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavParamType, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA};
use shared_control::params::Params;
use shared_control::params::encode;
use shared_control::sensing::imu_select::ImuUnit;

/// What was seen: as it should be, or not.
pub type Evidence = Result<String, String>;

/// Something that the documents say.
pub struct Finding {
    pub name: &'static str,
    pub source: &'static str,
    pub look: fn() -> Evidence,
}

/// What the firmware does not live up to yet.
pub const EXPECTED_TO_FAIL: &[&str] = &[];

pub const FINDINGS: &[Finding] = &[
    Finding {
        name: "AUX low as soon as the image starts",
        source: "TXS0108 (SCES642), PX4 #7182",
        look: aux_at_power_on,
    },
    Finding { name: "AUX low before and after a restart on purpose", source: "PX4 #7182, #7459", look: aux_at_restart },
    Finding { name: "AUX after a watchdog reset", source: "PX4 #7182", look: aux_at_watchdog },
    Finding { name: "a parameter sticks", source: "FM25V01 001-84497, AC characteristics", look: parameter_sticks },
    Finding { name: "a protected FRAM is noticed", source: "FM25V01 001-84497, status register", look: protected_fram },
    Finding { name: "FRAM left asleep", source: "FM25V01 001-84497, sleep mode, tREC", look: sleeping_fram },
    Finding {
        name: "FRAM's deselect time",
        source: "FM25V01 001-84497, tD",
        look: || keeps(rules::DESELECT_TOO_SHORT),
    },
    Finding {
        name: "pins fast enough for SPI clocks",
        source: "STM32F427 data sheet, I/O AC characteristics",
        look: || keeps(rules::PIN_TOO_SLOW),
    },
    Finding { name: "SPI's last bit", source: "ES0206, delayed SCK feedback", look: || keeps(rules::LAST_BIT_LATE) },
    Finding {
        name: "clocks at rest while a device listens",
        source: "RM0090 28.3.1",
        look: || keeps(rules::CLOCK_FLOATS),
    },
    Finding {
        name: "unpowered sensors are not fed",
        source: "MPU-6000 PS, absolute maximum ratings; schematic R621",
        look: || keeps(rules::BACK_FED),
    },
    Finding {
        name: "PC13 and PC15 source no current",
        source: "STM32F427 data sheet, output voltage, note 1",
        look: || keeps(rules::SOURCES_CURRENT),
    },
    Finding { name: "sensors' supply from zero", source: "MPU-6000 PS 6.3", look: || keeps(rules::RAMP_NOT_FROM_ZERO) },
    Finding { name: "MPU6000 comes up badly four times", source: "PX4 mpu6000.cpp", look: bad_starts },
    Finding { name: "MPU6000 slow or quick to start", source: "MPU-6000 PS 6.3", look: start_up_times },
    Finding {
        name: "MPU6000's signal paths reset",
        source: "RM-MPU-6000A 4.28",
        look: || keeps(rules::PATHS_NOT_RESET),
    },
    Finding { name: "MPU6000's select held", source: "MPU-6000 PS 6.8", look: || keeps(rules::SELECT_HOLD_TOO_SHORT) },
    Finding { name: "MPU6000 revision C", source: "PX4 mpu6000.h", look: revision_c },
    Finding {
        name: "another IMU in the MPU6000's place",
        source: "boards that are sold as Pixhawk 1; RM-MPU-9250A, DS-000081",
        look: clones,
    },
    Finding { name: "MPU6000's zero-g offset", source: "MPU-6000 PS 6.2", look: zero_g_offset },
    Finding { name: "flash prefetch", source: "RM0090 3.5.2", look: prefetch },
    Finding {
        name: "USB's pull-up only with the connector's 5 V",
        source: "USB 2.0 7.1.5.1; AN4879, self-powered devices",
        look: usb_pull_up,
    },
    Finding { name: "a dip of the supply of a microsecond", source: "RM0090 5.2.2", look: short_dip },
    Finding { name: "a supply that fails", source: "RM0090 5.2.2", look: long_dip },
    Finding { name: "the fault record without main power", source: "RM0090 5.1.2, schematic B601", look: backup },
    Finding { name: "slowest and fastest LSI", source: "STM32F427 data sheet, table 43", look: lsi },
    Finding { name: "a noisy TELEM1", source: "RM0090 30.3.3", look: noisy_link },
    Finding { name: "a heartbeat a second", source: "MAVLink heartbeat protocol", look: slow_heartbeats },
    Finding {
        name: "no motor pushes at zero throttle, tipped over",
        source: "ArduPilot crash_check.cpp",
        look: tipped_over,
    },
    Finding {
        name: "no motor stops in flight",
        source: "BLHeli manual; ArduPilot MOT_SPIN_MIN",
        look: stops_in_flight,
    },
    Finding { name: "armed motors turn", source: "ArduPilot MOT_SPIN_ARM", look: armed_turns },
    Finding {
        name: "a throttle stick in its middle lifts nothing",
        source: "ArduPilot, arming checks on the throttle",
        look: stick_in_the_middle,
    },
    Finding { name: "ESC calibration", source: "BLHeli manual, throttle calibration", look: calibrates_escs },
];

/// Shorter than any ESC takes for a pulse.
const UNSEEN: Ticks = 500 * TICKS_PER_US;
/// How long PX4 holds the lines low before it resets.
const LOW_BEFORE_RESET: Ticks = 40 * MILLISECOND;
/// What a second of flight stays below with prefetch and cache; a figure with more digits would change with each image.
const PREFETCHED_CYCLES: f64 = 2.0;

fn start() -> Flight {
    Flight::new(&Params::DEFAULT, 1)
}

fn us(ticks: Ticks) -> u64 {
    ticks / TICKS_PER_US
}

/// The time up to which the line is high if a pulse has not ended yet counts too.
fn longest(flight: &mut Flight, since: Ticks) -> Option<Pulse> {
    let now = flight.machine.now();
    let open = flight.machine.aux_high_since();
    let open = open
        .into_iter()
        .enumerate()
        .filter_map(|(channel, rise)| rise.map(|rise| Pulse { channel, rise, width: now - rise }));
    let vehicle = flight.vehicle.borrow();
    let ended = vehicle.line_pulses().iter().copied();
    ended.chain(open).filter(|pulse| pulse.rise + pulse.width > since).max_by_key(|pulse| pulse.width)
}

/// No pulse but the disarmed ones.
fn no_strange_pulse(flight: &mut Flight, since: Ticks) -> Evidence {
    let strange = |pulse: &Pulse| pulse.width > UNSEEN && us(pulse.width) != 1000;
    match longest(flight, since).filter(strange) {
        Some(pulse) => Err(format!("high for {} us from {} us on", us(pulse.width), us(pulse.rise))),
        None => {
            let vehicle = flight.vehicle.borrow();
            let glitches = vehicle.line_pulses().iter().filter(|pulse| pulse.width < UNSEEN && pulse.rise >= since);
            let glitch = glitches.map(|pulse| us(pulse.width)).max().unwrap_or(0);
            // to tens
            Ok(format!("nothing longer than {} us but disarmed pulses", (glitch + 1).div_ceil(10) * 10))
        }
    }
}

fn aux_at_power_on() -> Evidence {
    let mut seen = String::new();
    // both ends of what the line's capacitance may be
    for floats_low_us in [58, 0] {
        let mut flight = start();
        flight.machine.set_aux_floats_low(floats_low_us * TICKS_PER_US);
        flight.vehicle.borrow_mut().record_pulses();
        flight.run_for(1000 * MILLISECOND);
        seen = no_strange_pulse(&mut flight, 0)?;
    }
    Ok(seen)
}

fn aux_at_restart() -> Evidence {
    let mut flight = start();
    flight.machine.set_aux_floats_low(0);
    flight.run_for(2000 * MILLISECOND);
    flight.vehicle.borrow_mut().record_pulses();
    let before = flight.machine.now();
    flight.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
    flight.run_for(1500 * MILLISECOND);
    let reset = flight.machine.last_reset().ok_or("it did not restart")?;
    let seen = no_strange_pulse(&mut flight, before)?;
    let vehicle = flight.vehicle.borrow();
    let last = vehicle.line_pulses().iter().map(|pulse| pulse.rise + pulse.width).filter(|end| *end <= reset).max();
    let low = reset - last.ok_or("no pulse before the reset")?;
    if low < LOW_BEFORE_RESET {
        return Err(format!("low for {} us before the reset", us(low)));
    }
    let low_ms = low / (10 * MILLISECOND) * 10;
    Ok(format!("low for {low_ms} ms and more before the reset; {seen}"))
}

fn aux_at_watchdog() -> Evidence {
    let mut flight = start();
    flight.machine.set_aux_floats_low(0);
    flight.run_for(2000 * MILLISECOND);
    flight.vehicle.borrow_mut().record_pulses();
    let before = flight.machine.now();
    hang_loop(&mut flight);
    flight.run_for(1000 * MILLISECOND);
    flight.machine.last_reset().ok_or("no reset")?;
    no_strange_pulse(&mut flight, before)
}

/// `b .` in the loop until the watchdog has reset the board.
fn hang_loop(flight: &mut Flight) {
    let address = flight.image.symbol("TIM3").expect("a handler") & !1;
    let good = flight.machine.bytes(address, 2).unwrap();
    let resets = flight.machine.counters().resets;
    flight.machine.poke(address, &[0xfe, 0xe7]);
    for _ in 0..200 {
        flight.run_for(MILLISECOND / 2);
        if flight.machine.counters().resets > resets {
            break;
        }
    }
    flight.machine.poke(address, &good);
}

fn set(flight: &mut Flight, name: &str, param_value: f32) {
    let (param_id, param_type) = (name.into(), MavParamType::MAV_PARAM_TYPE_REAL32);
    let data = PARAM_SET_DATA { param_value, target_system: 1, target_component: 1, param_id, param_type };
    flight.ground.send(&mut flight.machine, &data);
    flight.run_for(300 * MILLISECOND);
}

/// What a run says that stops, as evidence.
fn unless_stopped(run: impl FnOnce() -> Evidence) -> Evidence {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let outcome = catch_unwind(AssertUnwindSafe(run));
    std::panic::set_hook(hook);
    outcome.unwrap_or_else(|panic| {
        Err(panic.downcast_ref::<String>().map_or_else(|| "the run stopped".to_owned(), |text| sentence(text)))
    })
}

/// Without what differs from build to build.
fn sentence(stop: &str) -> String {
    stop.split("\")").next().unwrap_or(stop).replace("Forbidden(\"", "")
}

fn parameter_sticks() -> Evidence {
    for load in [Load::Light, Load::Heavy] {
        unless_stopped(|| {
            let mut flight = start();
            flight.machine.set_load(load);
            flight.run_for(2000 * MILLISECOND);
            set(&mut flight, "PWM_RATE_HZ", 50.0);
            let wanted = encode(&Params { pwm_rate_hz: 50, ..Params::DEFAULT });
            let kept = flight.machine.read_fram(0, wanted.len()) == wanted;
            if kept { Ok(String::new()) } else { Err("the FRAM holds what it held".to_owned()) }
        })?;
    }
    Ok("stored, with light and heavy lines".to_owned())
}

fn protected_fram() -> Evidence {
    let mut flight = start();
    flight.machine.protect_fram(3);
    flight.run_for(2000 * MILLISECOND);
    set(&mut flight, "PWM_RATE_HZ", 50.0);
    let wanted = encode(&Params { pwm_rate_hz: 50, ..Params::DEFAULT });
    let kept = flight.machine.read_fram(0, wanted.len()) == wanted;
    let said = texts(&flight).join("; ");
    match (kept, said.contains("not stored")) {
        (true, _) => Ok("the protection is lifted and the parameter stored".to_owned()),
        (false, true) => Ok("the ground is told that nothing was stored".to_owned()),
        (false, false) => Err(format!("not stored; said: {said}")),
    }
}

/// Asleep while the board starts anew without a loss of power: what was stored counts.
fn sleeping_fram() -> Evidence {
    unless_stopped(|| {
        let mut flight = start();
        flight.run_for(2000 * MILLISECOND);
        set(&mut flight, "PWM_RATE_HZ", 50.0);
        flight.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
        let before = flight.machine.counters().resets;
        while flight.machine.counters().resets == before {
            flight.run_for(MILLISECOND);
        }
        flight.machine.put_fram_to_sleep();
        flight.run_for(2000 * MILLISECOND);
        let (param_id, target_system, target_component) = ("PWM_RATE_HZ".into(), 1, 1);
        let request = PARAM_REQUEST_READ_DATA { param_index: -1, target_system, target_component, param_id };
        flight.ground.send(&mut flight.machine, &request);
        flight.run_for(300 * MILLISECOND);
        let kept = flight.ground.parameter("PWM_RATE_HZ");
        if kept == Some(50.0) {
            Ok("what was stored before is read behind a restart".to_owned())
        } else {
            Err(format!("PWM_RATE_HZ 50 was stored, {kept:?} is read"))
        }
    })
}

fn texts(flight: &Flight) -> Vec<String> {
    flight.ground.texts().iter().map(|(_, text)| text.clone()).collect()
}

/// Boots, stores a parameter, arms, disarms, restarts: the rules that were broken meanwhile.
fn at_a_desk() -> Vec<Broken> {
    let mut flight = start();
    flight.machine.tolerate(&rules::ALL);
    flight.run_for(3500 * MILLISECOND);
    set(&mut flight, "PWM_RATE_HZ", 400.0);
    for arm in [1.0, 0.0] {
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, arm);
        flight.run_for(200 * MILLISECOND);
    }
    flight.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
    flight.run_for(1500 * MILLISECOND);
    flight.machine.broken_rules()
}

fn keeps(rule: &'static str) -> Evidence {
    static BROKEN: std::sync::OnceLock<Vec<Broken>> = std::sync::OnceLock::new();
    match BROKEN.get_or_init(at_a_desk).iter().find(|broken| broken.rule == rule) {
        Some(broken) => {
            let often =
                if broken.times < 100 { format!("{} times", broken.times) } else { "again and again".to_owned() };
            Err(format!("broken {often}, first at {} ms", broken.first / MILLISECOND))
        }
        None => Ok("kept from power-on over arming to a restart".to_owned()),
    }
}

/// It boots with this MPU6000 as the only IMU, and arms.
fn arms_with(revision: Mpu6000Revision, bad_starts: u8, slowest: bool) -> Evidence {
    let mut flight = start();
    flight.machine.break_sensor(Sensor::L3gd20, SensorFault::Removed(0xff));
    flight.machine.break_sensor(Sensor::Lsm303d, SensorFault::Removed(0xff));
    flight.machine.set_mpu6000(revision, bad_starts);
    flight.machine.set_mpu6000_start_up(slowest);
    flight.run_for(5500 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(200 * MILLISECOND);
    let [_, _, _, _, _, _, _, down] = flight.last().sample[0];
    let g = f64::from(down as i32) / 4096.0;
    if !flight.is_armed() {
        return Err(texts(&flight).join("; "));
    }
    if (g + 1.0).abs() > 0.1 { Err(format!("feels {g:.2} g")) } else { Ok(format!("arms, feels {g:.1} g")) }
}

fn bad_starts() -> Evidence {
    (1..4).try_for_each(|times| arms_with(Mpu6000Revision::D, times, false).map(|_| ()))?;
    arms_with(Mpu6000Revision::D, 4, false)
}

fn start_up_times() -> Evidence {
    arms_with(Mpu6000Revision::D, 0, false)?;
    arms_with(Mpu6000Revision::D, 0, true)
}

fn revision_c() -> Evidence {
    arms_with(Mpu6000Revision::C, 0, false)
}

/// Where another chip answers, the second IMU flies, and the ground is told why.
fn clones() -> Evidence {
    for revision in [Mpu6000Revision::Mpu9250, Mpu6000Revision::Icm20608] {
        let mut flight = start();
        flight.machine.set_mpu6000(revision, 0);
        flight.run_for(5500 * MILLISECOND);
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        flight.run_for(200 * MILLISECOND);
        let said = texts(&flight).join("; ");
        let second_flies = flight.is_armed() && flight.last().imu_unit == ImuUnit::Second.number();
        if !second_flies || !said.contains("MPU6000 does not answer as itself") {
            return Err(format!("{revision:?}: {said}"));
        }
    }
    Ok("MPU-9250, ICM-20608: said, and the second IMU in use".to_owned())
}

/// At both ends of the range, across and along the vertical: tilt that the level vehicle shows, before and after its
/// level calibration.
fn zero_g_offset() -> Evidence {
    let mut most_deg = [0.0_f64; 2];
    for sign in [-1.0, 1.0] {
        let mut flight = start();
        flight.vehicle.borrow_mut().offset_accelerometer([0.05, -0.05, 0.08].map(|g| sign * g * 9.806_65));
        flight.run_for(5000 * MILLISECOND);
        most_deg[0] = most_deg[0].max(shown_tilt_deg(&flight));
        let (command, target_system, target_component) = (MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION, 1, 1);
        let data = COMMAND_LONG_DATA { command, param5: 2.0, target_system, target_component, ..Default::default() };
        flight.ground.send(&mut flight.machine, &data);
        flight.run_for(300 * MILLISECOND);
        flight.restart_board();
        most_deg[1] = most_deg[1].max(shown_tilt_deg(&flight));
    }
    let [before_deg, after_deg] = most_deg;
    let seen =
        format!("50 mg across, 80 along the vertical: {before_deg:.0} degrees of tilt, 0.2 at most once calibrated");
    if before_deg < 3.0 || after_deg > 0.2 { Err(format!("{seen}: {after_deg:.2}")) } else { Ok(seen) }
}

/// Angle between the estimated vertical and the vehicle's axis.
fn shown_tilt_deg(flight: &Flight) -> f64 {
    let [w, i, j, k] = flight.last().attitude.map(|word| f64::from(f32::from_bits(word)));
    (w * w - i * i - j * j + k * k).clamp(-1.0, 1.0).acos().to_degrees()
}

fn prefetch() -> Evidence {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 1);
    let before = flight.machine.counters();
    flight.run_for(1000 * MILLISECOND);
    let after = flight.machine.counters();
    let each = (after.cycles - before.cycles) as f64 / (after.instructions - before.instructions) as f64;
    let seen = format!("{each:.2} cycles an instruction in flight, exceptions included");
    match (flight.machine.prefetches(), each < PREFETCHED_CYCLES) {
        (true, true) => {
            Ok(format!("less than {PREFETCHED_CYCLES} cycles an instruction in flight, exceptions included"))
        }
        (true, false) => Err(seen),
        (false, _) => Err(format!("off: {seen}")),
    }
}

fn short_dip() -> Evidence {
    for duration_us in [1, 10] {
        let mut flight = Flight::in_the_air(&Params::DEFAULT, 1);
        flight.machine.dip_supply(2.8, duration_us * TICKS_PER_US);
        flight.run_for(50 * MILLISECOND);
        if flight.machine.counters().resets > 0 || !flight.is_armed() {
            return Err(format!("{duration_us} us below 2.9 V stop the motors in flight"));
        }
    }
    Ok("1 and 10 us below 2.9 V: flies on".to_owned())
}

fn long_dip() -> Evidence {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 1);
    let fault = flight.machine.now();
    flight.machine.dip_supply(2.8, 20 * MILLISECOND);
    flight.run_for(20 * MILLISECOND);
    let live = flight.vehicle.borrow().pulses().last_live_end().saturating_sub(fault);
    if live > 3 * MILLISECOND {
        Err(format!("motors on for {} us", us(live)))
    } else {
        Ok("motors off within 3 ms".into())
    }
}

fn backup() -> Evidence {
    let mut flight = start();
    flight.run_for(2000 * MILLISECOND);
    flight.machine.stop_crystal();
    flight.run_for(100 * MILLISECOND);
    flight.machine.mend_crystal();
    flight.machine.power_cycle_with_battery(7);
    // the loop has begun again without a reset that its trace could tell
    let quiet = flight.machine.now() + 2000 * MILLISECOND;
    while flight.machine.now() < quiet {
        let until = flight.machine.now() + MILLISECOND;
        flight.machine.run_until(until).map_err(|stop| stop.to_string())?;
        flight.ground.listen(&mut flight.machine);
    }
    let texts = texts(&flight);
    match texts.iter().any(|text| text.starts_with("crystal lost")) {
        true => {
            Ok("read after ten thousand years without a plug, and a battery".replace("ten thousand years", "a start"))
        }
        false => Err(format!("lost: {}", texts.join("; "))),
    }
}

fn lsi() -> Evidence {
    let mut seen = Vec::new();
    for lsi_hz in LSI_RANGE_HZ {
        let mut flight = start();
        flight.machine.set_lsi_hz(lsi_hz);
        flight.take_off();
        flight.run_for(1000 * MILLISECOND);
        if flight.machine.counters().resets > 0 {
            return Err(format!("resets itself at {lsi_hz} Hz"));
        }
        let hung = flight.machine.now();
        hang_loop(&mut flight);
        let reset = flight.machine.last_reset().ok_or("no reset")? - hung;
        // in steps of ten: where in the watchdog's time it hangs is another build's affair
        seen.push(format!("{} ms at {} kHz", reset.div_ceil(10 * MILLISECOND) * 10, lsi_hz / 1000));
        if reset > 58 * MILLISECOND {
            return Err(format!("a loop that hangs is reset within {}", seen.join(", ")));
        }
    }
    Ok(format!("a loop that hangs is reset within {}", seen.join(", ")))
}

fn noisy_link() -> Evidence {
    let mut flight = start();
    flight.run_for(3500 * MILLISECOND);
    flight.machine.telem1_noise(2, 2);
    // the ground repeats what is not answered
    for _ in 0..10 {
        if !flight.is_armed() {
            flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        }
        flight.run_for(300 * MILLISECOND);
    }
    let armed = flight.is_armed();
    flight.run_for(5000 * MILLISECOND);
    let said = texts(&flight).join("; ");
    match (armed, flight.is_armed()) {
        (true, true) => Ok("0.2 % of bytes lost, 0.2 % damaged: arms and stays armed for 5 s".to_owned()),
        _ => Err(format!("armed {armed}, then not: {said}")),
    }
}

/// Flies, then somebody closes the throttle.
fn idles_after_flight(traits: EscTraits, prepare: fn(&mut Flight)) -> Flight {
    let mut flight = start();
    flight.vehicle.borrow_mut().watch_with(traits, 0);
    flight.take_off();
    flight.run_for(1000 * MILLISECOND);
    prepare(&mut flight);
    flight.hold_throttle(0);
    flight.run_for(100 * MILLISECOND);
    flight
}

fn tipped_over() -> Evidence {
    let on_its_side = |flight: &mut Flight| {
        flight.vehicle.borrow_mut().tip_over(80_f64.to_radians());
        flight.run_for(600 * MILLISECOND);
    };
    let mut flight = idles_after_flight(EscTraits::CAREFUL, on_its_side);
    let mut highest = 0.0_f64;
    for _ in 0..50 {
        flight.run_for(10 * MILLISECOND);
        highest = flight.vehicle.borrow().commands().into_iter().fold(highest, f64::max);
    }
    let seen = format!("pulses of {:.0} us at most, lying on its side at zero throttle", 1000.0 * (1.0 + highest));
    // ArduPilot's MOT_SPIN_MIN is 0.15 of the range
    if highest > 0.16 { Err(seen) } else { Ok(seen) }
}

fn stops_in_flight() -> Evidence {
    for traits in [EscTraits::EAGER, EscTraits::CAREFUL] {
        let mut flight = idles_after_flight(traits, |_| {});
        flight.run_for(3000 * MILLISECOND);
        let stops = flight.vehicle.borrow_mut().escs().each_ref().map(|esc| esc.stops()).iter().sum::<u32>();
        if stops > 0 {
            return Err(format!(
                "{stops} motors stop in the air when told to idle, dead band to {:.0} us",
                traits.dead_band_end_us
            ));
        }
    }
    Ok("none, told to idle in the air".to_owned())
}

/// A person beside a vehicle that is armed sees that it is.
fn armed_turns() -> Evidence {
    for traits in [EscTraits::EAGER, EscTraits::CAREFUL] {
        let mut flight = start();
        flight.vehicle.borrow_mut().watch_with(traits, 0);
        flight.run_for(3500 * MILLISECOND);
        flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        flight.run_for(500 * MILLISECOND);
        let now = flight.machine.now();
        let turning =
            flight.vehicle.borrow_mut().escs().iter_mut().filter_map(|esc| esc.turns(now).then_some(())).count();
        if turning < 4 {
            return Err(format!("{turning} motors turn, dead band to {:.0} us", traits.dead_band_end_us));
        }
    }
    Ok("all motors turn within 0.5 s of arming".to_owned())
}

/// A joystick whose throttle springs back to its middle.
fn stick_in_the_middle() -> Evidence {
    let mut flight = start();
    flight.run_for(3500 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(200 * MILLISECOND);
    let highest_of = |flight: &mut Flight| {
        flight.run_for(500 * MILLISECOND);
        flight.vehicle.borrow().commands().into_iter().fold(0.0, f64::max)
    };
    flight.hold_throttle(500);
    let before = highest_of(&mut flight);
    flight.hold_throttle(0);
    flight.run_for(200 * MILLISECOND);
    flight.hold_throttle(500);
    let after = highest_of(&mut flight);
    let seen = format!("armed with it at half: {:.0} us at most", 1000.0 * (1.0 + before));
    if before > 0.16 || !flight.is_armed() {
        Err(seen)
    } else if after < 0.4 {
        Err(format!("{seen}; nor after it was low"))
    } else {
        Ok(format!("{seen}; once it was low it counts"))
    }
}

/// All that a person does: battery on and off at a board fed over USB, the command, battery on, wait.
fn calibrates_escs() -> Evidence {
    let mut flight = Flight::new(&Params { esc_calibration: true, ..Params::DEFAULT }, 1);
    let calibrate = |flight: &mut Flight| {
        let (target_system, target_component) = (1, 1);
        let command = MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION;
        let data =
            COMMAND_LONG_DATA { command, param7: 1.0, target_system, target_component, ..COMMAND_LONG_DATA::DEFAULT };
        flight.ground.send(&mut flight.machine, &data);
        flight.run_for(500 * MILLISECOND);
    };
    let full = |flight: &Flight| flight.vehicle.borrow().commands().iter().any(|command| *command > 0.5);
    flight.machine.set_battery_v(0.1);
    flight.run_for(3000 * MILLISECOND);
    // no battery was ever seen: it may be that nobody measures it
    calibrate(&mut flight);
    let doubted = !full(&flight);
    flight.machine.set_battery_v(12.4);
    flight.run_for(500 * MILLISECOND);
    calibrate(&mut flight);
    let refused = !full(&flight);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(300 * MILLISECOND);
    let stays_disarmed = !flight.is_armed();
    flight.machine.set_battery_v(0.1);
    flight.run_for(500 * MILLISECOND);
    calibrate(&mut flight);
    let sends_full = full(&flight);
    flight.run_for(2000 * MILLISECOND);
    let now = flight.machine.now();
    flight.vehicle.borrow_mut().watch_with(EscTraits::CAREFUL, now);
    flight.machine.set_battery_v(12.4);
    flight.run_for(3000 * MILLISECOND);
    let now = flight.machine.now();
    let learning = flight.vehicle.borrow_mut().escs().iter_mut().all(|esc| esc.mode(now) == EscMode::Calibrating);
    flight.run_for(6000 * MILLISECOND);
    let over = flight.vehicle.borrow().commands() == [0.0; 4];
    let said = texts(&flight).iter().any(|text| text.starts_with("ESCs calibrated"));
    match (doubted, refused, stays_disarmed, sends_full, learning, over && said) {
        (true, true, true, true, true, true) => {
            Ok("refused with power on or never seen; full pulse before power, then low, told each step".to_owned())
        }
        steps => {
            Err(format!("doubted, refused, not armed, full, learning, over: {steps:?}; {}", texts(&flight).join("; ")))
        }
    }
}

fn slow_heartbeats() -> Evidence {
    let mut flight = start();
    // a computer's timer and a radio's queue: a tenth late
    flight.set_heartbeat_period(1100 * MILLISECOND);
    flight.run_for(3500 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(10_000 * MILLISECOND);
    if flight.is_armed() { Ok("armed for 10 s".to_owned()) } else { Err(texts(&flight).join("; ")) }
}

/// Fed by a battery, with a cable that comes and goes.
fn usb_pull_up() -> Evidence {
    /// A look at the pin every 10 ms, and as long again.
    const IN_TIME: Ticks = 20 * MILLISECOND;
    let mut flight = start();
    flight.run_for(500 * MILLISECOND);
    let mut seen = Vec::new();
    for plugged in [false, true, false, true] {
        flight.machine.with_usb(|computer| computer.plug(plugged));
        flight.run_for(IN_TIME);
        let first = flight.machine.pulls_usb_up();
        flight.run_for(300 * MILLISECOND);
        seen.push([first, flight.machine.pulls_usb_up()]);
    }
    let wanted = [[false; 2], [true; 2], [false; 2], [true; 2]];
    if seen == wanted { Ok("follows within 20 ms".to_owned()) } else { Err(format!("{seen:?}")) }
}
