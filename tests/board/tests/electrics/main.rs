//! scratch
use emulated_board::{Flight, MILLISECOND, rules};
use emulated_board::time::TICKS_PER_US;
use shared_control::params::Params;
#[test]
fn explore() {
    let mut flight = Flight::new(&Params::DEFAULT, 1);
    flight.vehicle.borrow_mut().record_pulses();
    let start = std::time::Instant::now();
    for ms in 0..3500 {
        flight.run_for(MILLISECOND);
        if ms < 5 || ms % 250 == 0 { println!("{ms} ms high {:?}", flight.machine.aux_high_since().map(|h| h.map(|h| h / TICKS_PER_US))); }
    }
    for b in flight.machine.broken_rules() { println!("{} us: {} x {}", b.first / TICKS_PER_US, b.times, b.rule); }
    let v = flight.vehicle.borrow();
    for p in v.line_pulses().iter().take(12) { println!("line ch {} rise {} us width {} us", p.channel, p.rise / TICKS_PER_US, p.width / TICKS_PER_US); }
    for p in v.recorded_pulses().iter().take(4) { println!("timer ch {} rise {} us width {} us", p.channel, p.rise / TICKS_PER_US, p.width / TICKS_PER_US); }
    println!("{:?} wall {:?}", flight.machine.counters(), start.elapsed());
    println!("{:?}", flight.ground.texts());
    let _ = rules::ALL;
}
