//! One flight, and what was measured of it.

use std::collections::BTreeMap;
use std::time::Instant;

use emulated_board::time::{TICKS_PER_S, Ticks, seconds};
use emulated_board::{Flight, MILLISECOND, Planned, Profile};
use shared_control::params::Params;

const HOUSEKEEPING: &str = "housekeeping";
const CORE_HZ: u64 = 168_000_000;
/// Interrupts and the tasks behind them.
const TASKS: [(u8, &str); 10] = [
    (29, "loop"),
    (40, "first IMU ready"),
    (6, "second IMU ready"),
    (56, "IMU received"),
    (71, "IO replied"),
    (38, "link idle"),
    (16, "link ring"),
    (17, "link sent"),
    (20, "plan"),
    (21, HOUSEKEEPING),
];

/// Instructions, and cycles at worst, of a task's activations, without what interrupted them.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    pub median: u32,
    pub worst: u32,
    pub worst_cycles: u32,
    pub activations: u64,
}

/// Figures of a flight.
pub struct Flown {
    pub name: &'static str,
    pub loop_rate_hz: u16,
    pub steps: u64,
    pub planned: Planned,
    /// As the image counts them.
    pub late_plans: u32,
    pub overruns: u32,
    /// Shortest and longest from tick to edge.
    pub delay: Option<(Ticks, Ticks)>,
    pub pulses: u64,
    pub tasks: BTreeMap<&'static str, Task>,
    pub cpu_permille: u64,
    pub stack_bytes: usize,
    pub flash_bytes: usize,
    pub ram_bytes: usize,
    pub computes_in_f64: bool,
    /// Of the control loop, while the figures were taken.
    steps_profiled: u64,
    instructions_per_step: u64,
    deviation_deg: [f64; 2],
    times_real_time: f64,
}

impl Flown {
    /// Flies the sequence, or its beginning; the whole of it ends on the ground.
    pub fn new(name: &'static str, params: &Params, duration_s: f64) -> Self {
        let mut flight = Flight::in_the_air(params, 1);
        let (steps, instructions) = (flight.twin.steps(), flight.machine.counters().instructions);
        let (start, cpu_s, took_off) = (Instant::now(), cpu_time_s(), flight.machine.now());
        flight.run_for((duration_s * TICKS_PER_S as f64) as Ticks);
        let elapsed_s = cpu_time_s().zip(cpu_s).map_or(start.elapsed().as_secs_f64(), |(end, start)| end - start);
        let steps_flown = flight.twin.steps() - steps;
        let instructions_per_step = (flight.machine.counters().instructions - instructions) / steps_flown;
        let profile = flight.machine.profile();
        let asleep = seconds(profile.asleep()) / seconds(flight.machine.now() - took_off);
        let (tasks, deviation_deg) = (tasks(profile), flight.deviation_deg());
        if duration_s > 20.0 {
            end_on_the_ground(&mut flight);
        }
        let (delay, pulses) = (flight.vehicle.borrow().delays().range(), flight.vehicle.borrow().delays().count());
        assert_eq!(flight.machine.counters().resets, 0, "{name}: {:?}", flight.ground.texts());
        assert!(!flight.vehicle.borrow().pulses().cut(), "{name}: a pulse was cut");
        Self {
            name,
            loop_rate_hz: params.loop_rate_hz,
            steps: flight.twin.steps(),
            planned: flight.twin.planned(),
            late_plans: flight.counter("LATE_PLANS"),
            overruns: flight.counter("LOOP_OVERRUNS"),
            delay,
            pulses,
            tasks,
            cpu_permille: (1000.0 * (1.0 - asleep)) as u64,
            stack_bytes: flight.stack_used_bytes(),
            flash_bytes: flight.image.flash_bytes(),
            ram_bytes: flight.image.ram_bytes(),
            computes_in_f64: flight.image.computes_in_f64(),
            steps_profiled: steps_flown,
            instructions_per_step,
            deviation_deg,
            times_real_time: duration_s / elapsed_s,
        }
    }

    /// If every task but housekeeping, which waits for all others, had its worst activation in one and the same step,
    /// as often as it runs in one: share of the step, 1/1000.
    pub fn worst_step_permille(&self) -> u64 {
        let urgent = self.tasks.iter().filter(|(name, _)| **name != HOUSEKEEPING);
        let cycles =
            urgent.map(|(_, task)| u64::from(task.worst_cycles) * task.activations.div_ceil(self.steps_profiled));
        1000 * cycles.sum::<u64>() / (CORE_HZ / u64::from(self.loop_rate_hz))
    }

    pub fn print(&self) {
        let Self { name, steps, deviation_deg, instructions_per_step, times_real_time, planned, .. } = self;
        let [cpu_percent, worst_percent] = [self.cpu_permille, self.worst_step_permille()].map(|it| it as f64 / 10.0);
        println!("{name}: {steps} steps repeated by the host, 0 bits of difference");
        println!("{name}: mean |set-point - angle| {deviation_deg:.2?} deg");
        println!("{name}: {instructions_per_step} instructions a step, all tasks together, CPU {cpu_percent:.1} %");
        println!("{name}: control, IO and link {worst_percent:.1} % of a step, each at its worst");
        println!("{name}: {times_real_time:.1} times real time on a core of its own");
        if planned.repeated > 0 {
            println!("{name}: {planned:?}");
        }
        for (task, Task { median, worst, worst_cycles, .. }) in &self.tasks {
            println!("{name}: {task}: median {median}, worst {worst} instructions, {worst_cycles} cycles");
        }
    }
}

/// It went to all positions of 30 degrees and stayed near what was requested; steps of 30 degrees make up most of the
/// mean.
fn end_on_the_ground(flight: &mut Flight) {
    assert!((25.0..45.0).contains(&flight.largest_tilt_deg()), "{}", flight.largest_tilt_deg());
    assert!(flight.deviation_deg().iter().all(|mean| *mean < 5.0), "{:?}", flight.deviation_deg());
    flight.run_for(250 * MILLISECOND);
    assert!(!flight.is_armed());
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
}

fn tasks(profile: &Profile) -> BTreeMap<&'static str, Task> {
    let mut tasks = BTreeMap::new();
    for interrupt in profile.interrupts() {
        let (_, name) = TASKS.iter().find(|(number, _)| *number == interrupt).expect("a task of the table");
        tasks.insert(*name, task([profile.of_interrupt(interrupt), profile.cycles_of_interrupt(interrupt)]));
    }
    tasks.insert("IO slot", task(profile.of_sys_tick()));
    tasks
}

/// Of its activations' instructions and cycles.
fn task([instructions, cycles]: [&[u32]; 2]) -> Task {
    let mut counts = instructions.to_vec();
    counts.sort_unstable();
    let (median, worst) = (counts[counts.len() / 2], counts[counts.len() - 1]);
    let (worst_cycles, activations) = (cycles.iter().copied().max().unwrap_or(0), cycles.len() as u64);
    Task { median, worst, worst_cycles, activations }
}

/// What this thread has spent, where the system tells (Linux): others on the machine do not count.
fn cpu_time_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}
