//! The test sequence is written down twice: in the core, which flies it on the board, and as the simulator's scenario.

use shared_control::test_sequence;
use sil_host::scenario::Scenario;

#[test]
fn board_and_simulator_fly_the_same_sequence() {
    let scenario = Scenario::test_sequence();
    assert_eq!(test_sequence::DURATION_US, (scenario.duration_s * 1e6).round() as u64);
    // every control step at 400 Hz and the microseconds around each change
    let steps = (0..test_sequence::DURATION_US).step_by(2500);
    let changes = scenario.waypoints.iter().flat_map(|waypoint| {
        let change_us = (waypoint.start_s * 1e6).round() as u64;
        [change_us.saturating_sub(1), change_us, change_us + 1]
    });
    for time_us in steps.chain(changes) {
        let waypoint = scenario.at(time_us as f64 * 1e-6);
        let setpoint = test_sequence::at(time_us, 0.5).expect("within the sequence");
        // degrees turn into radians in f32 on the board, in f64 in the simulator: one rounding of f32 apart
        let apart = |board: f32, simulator: f64| (f64::from(board) - simulator).abs();
        assert!(apart(setpoint.roll_rad, waypoint.roll_rad) < 1e-7, "roll at {time_us} us");
        assert!(apart(setpoint.pitch_rad, waypoint.pitch_rad) < 1e-7, "pitch at {time_us} us");
        assert!(waypoint.yaw_rate_rad_s == 0.0 && setpoint.yaw_rate_rad_s == 0.0);
        assert!(waypoint.throttle.is_none() && setpoint.throttle == 0.5);
    }
    assert_eq!(test_sequence::at(test_sequence::DURATION_US, 0.5), None);
}
