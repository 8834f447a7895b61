use super::*;

/// 168 MHz / 7, 400 Hz, PWM mode 1 with preload on channel 4.
fn motor_timer() -> Timer {
    let mut timer = Timer::advanced();
    timer.set_cycle(2, 0);
    for (offset, value) in
        [(0x28, 6), (0x2c, 59_999), (0x1c, 0x6800), (0x20, 1 << 12), (0x40, 24_000), (0x14, 1), (0x10, 0), (0x44, MOE)]
    {
        timer.write(offset, value, 0).unwrap();
    }
    timer
}

#[test]
fn the_period_is_exact_and_the_update_flag_is_cleared_by_writing_zero() {
    let mut timer = Timer::general(0xffff);
    timer.set_cycle(4, 0);
    timer.write(0x28, 83, 0).unwrap();
    timer.write(0x2c, 2499, 0).unwrap();
    timer.write(0x14, UG, 0).unwrap();
    timer.write(0x10, 0, 0).unwrap();
    timer.write(0x0c, UIF, 0).unwrap();
    timer.write(0x00, CEN, 0).unwrap();
    let period = 2500 * 336;
    assert_eq!(timer.next_event(), Some(period));
    timer.tick(period - 1);
    assert!(!timer.update_interrupt());
    timer.tick(period);
    assert!(timer.update_interrupt());
    timer.write(0x10, !UIF, period).unwrap();
    assert!(!timer.update_interrupt());
    assert_eq!(timer.read(0x24, period + 336 * 7).unwrap(), 7);
    assert_eq!(timer.next_event(), Some(2 * period));
}

#[test]
fn a_new_compare_value_waits_for_the_update() {
    let mut timer = motor_timer();
    timer.write(0x00, CEN, 0).unwrap();
    timer.tick(336_000);
    assert_eq!(timer.take_pulses(), [Pulse { channel: 3, rise: 0, width: 336_000 }]);
    timer.write(0x40, 48_000, 500_000).unwrap();
    timer.tick(840_000 + 672_000);
    assert_eq!(timer.take_pulses(), [Pulse { channel: 3, rise: 840_000, width: 672_000 }]);
}

#[test]
fn without_preload_a_compare_value_acts_at_once_and_makes_no_pulse_in_the_past() {
    let mut timer = motor_timer();
    timer.write(0x00, CEN, 0).unwrap();
    // 32,000 and 10,000 counts later, long after this period's pulse
    for now in [448_000, 588_000] {
        timer.write(0x1c, 0x6000, now).unwrap();
        timer.write(0x40, 24_000, now).unwrap();
    }
    timer.tick(839_999);
    assert_eq!(timer.take_pulses(), [Pulse { channel: 3, rise: 0, width: 336_000 }]);
    // into a pulse, and shorter than it is: it ends there
    timer.write(0x40, 12_000, 840_000 + 252_000).unwrap();
    assert_eq!(timer.take_pulses(), [Pulse { channel: 3, rise: 840_000, width: 252_000 }]);
}

#[test]
fn without_main_output_enable_the_pin_is_low() {
    let mut timer = motor_timer();
    timer.write(0x44, 0, 0).unwrap();
    timer.take_pulses();
    timer.write(0x00, CEN, 0).unwrap();
    timer.tick(3 * 840_000);
    assert_eq!(timer.take_pulses(), []);
}

#[test]
fn a_slower_clock_stretches_what_is_left() {
    let mut timer = motor_timer();
    timer.write(0x00, CEN, 0).unwrap();
    // half of the pulse at 168 MHz, half at 16 MHz
    timer.set_cycle(21, 12_000 * 14);
    assert_eq!(timer.count(12_000 * 14), 12_000);
    let end = 12_000 * 14 + 12_000 * 7 * 21;
    timer.tick(end);
    assert_eq!(timer.take_pulses(), [Pulse { channel: 3, rise: 0, width: end }]);
}

#[test]
fn a_tone_has_the_frequency_of_its_period_and_none_at_a_level() {
    let mut timer = Timer::general(u32::MAX);
    timer.set_cycle(4, 0);
    for (offset, value) in [(0x28, 83), (0x18, 0x68), (0x20, 1), (0x2c, 499), (0x34, 250), (0x14, UG)] {
        timer.write(offset, value, 0).unwrap();
    }
    assert_eq!(timer.wave_hz(0), None);
    timer.write(0x00, CEN, 0).unwrap();
    assert_eq!(timer.wave_hz(0), Some(2000.0));
    // nothing waits for it
    assert_eq!(timer.next_event(), None);
    timer.write(0x34, 0, 0).unwrap();
    timer.write(0x14, UG, 0).unwrap();
    assert_eq!(timer.wave_hz(0), None);
}

#[test]
fn an_update_by_software_acts_at_once() {
    let mut timer = motor_timer();
    timer.write(0x00, CEN, 0).unwrap();
    timer.tick(400_000);
    timer.take_pulses();
    timer.write(0x40, 30_000, 400_000).unwrap();
    timer.write(0x14, UG, 400_000).unwrap();
    timer.tick(400_000 + 30_000 * 14);
    assert_eq!(timer.take_pulses(), [Pulse { channel: 3, rise: 400_000, width: 420_000 }]);
}

#[test]
fn without_preload_a_pulse_beyond_its_new_end_ends_once_and_at_once() {
    let mut timer = motor_timer();
    for (offset, value) in [(0x1c, 0x6868), (0x20, 1 << 12 | 1 << 8), (0x00, CEN)] {
        timer.write(offset, value, 0).unwrap();
    }
    for channel in [2, 3] {
        timer.write(0x34 + 4 * channel, 30_000, 0).unwrap();
    }
    timer.write(0x14, UG, 0).unwrap();
    timer.write(0x1c, timer.mode[1] & !0x0808, 350_000).unwrap();
    for channel in [2, 3] {
        timer.write(0x34 + 4 * channel, 20_000, 350_000).unwrap();
    }
    timer.tick(420_000);
    let pulse = |channel| Pulse { channel, rise: 0, width: 350_000 };
    assert_eq!(timer.take_pulses(), [pulse(2), pulse(3)]);
}

#[test]
fn edges_that_are_seen_late_keep_their_times() {
    let mut timer = motor_timer();
    for (offset, value) in [(0x1c, 0x6868), (0x20, 1 << 12 | 1 << 8), (0x3c, 30_000), (0x14, UG), (0x00, CEN)] {
        timer.write(offset, value, 0).unwrap();
    }
    // channel 4 ends first, both before anybody looks
    timer.tick(500_000);
    let pulse = |channel, counts: Ticks| Pulse { channel, rise: 0, width: 14 * counts };
    assert_eq!(timer.take_pulses(), [pulse(3, 24_000), pulse(2, 30_000)]);
}

#[test]
fn a_slave_in_trigger_mode_starts_with_its_master() {
    let mut master = Timer::general(0xffff);
    master.set_cycle(4, 0);
    master.write(0x2c, 99, 0).unwrap();
    master.write(0x04, TRGO_UPDATE << 4, 0).unwrap();
    master.write(0x00, CEN, 0).unwrap();
    let mut slave = motor_timer();
    slave.write(0x08, 2 << 4 | SLAVE_TRIGGER, 0).unwrap();
    assert_eq!(slave.trigger_input(), Some(2));
    master.tick(399);
    assert!(master.take_triggers().is_empty());
    master.tick(400);
    assert_eq!(master.take_triggers(), [400]);
    slave.trigger(400);
    assert_eq!(slave.count(400 + 14 * 5), 5);
    // a second trigger does not disturb it
    slave.trigger(800);
    assert_eq!(slave.count(400 + 14 * 50), 50);
}

#[test]
fn a_channel_lets_its_pin_go_until_it_is_enabled_and_the_main_output_too() {
    let mut timer = Timer::advanced();
    timer.set_cycle(2, 0);
    let outputs = |timer: &mut Timer| timer.take_edges().into_iter().map(|edge| edge.output).collect::<Vec<_>>();
    timer.write(0x18, 0x68, 0).unwrap();
    timer.write(0x34, 100, 0).unwrap();
    timer.write(0x20, 1, 0).unwrap();
    assert_eq!((timer.output(0), outputs(&mut timer)), (None, vec![]));
    timer.write(0x44, MOE, 0).unwrap();
    assert_eq!(outputs(&mut timer), [Some(false)]);
    timer.write(0x44, 0, 10).unwrap();
    assert_eq!(outputs(&mut timer), [None]);
    // with OSSI it is held low
    timer.write(0x44, OSSI, 10).unwrap();
    assert_eq!(outputs(&mut timer), [Some(false)]);
}
