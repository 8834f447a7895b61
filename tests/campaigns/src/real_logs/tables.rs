//! The tables of docs/real-logs.md.

use super::crazyflie::vehicle;
use super::crazyflie_table::{RollPitch, yaw_of};
use super::crazyflie_yaw::yaw_sizes;
use super::{bench, crazyflie_known, crazypad, crazypad_baseline, files, load};

/// Prints all of them.
///
/// # Panics
/// The logs are there and can't be read.
pub fn print() {
    println!("# Bench with a free pitch (ANT-X)\n");
    println!("| run | pitch, deg: nominal, extended | q, deg/s: nominal, extended | findings |\n|---|---|---|---|");
    for path in files("rig_antx_2dof", "Lab") {
        print!("{}", bench::Run::of(&path));
    }
    println!("\n# Crazyflie flown for identification (ARP lab)\n");
    for path in files("flight_crazyflie_arplab", "log15") {
        let log = load(&path, "crazyflie_arplab");
        println!("{}", RollPitch::of(&log, &vehicle()));
        for part_s in crazyflie_known::PARTS_S {
            let answer = crazyflie_known::diagnosis(&log, &vehicle(), part_s);
            let found: Vec<&str> = answer.findings.iter().map(|finding| finding.statement.as_str()).collect();
            println!("mass known, {part_s:?} s: {}", found.join(" "));
        }
    }
    for path in files("flight_crazyflie_arplab", "log16") {
        let log = load(&path, "crazyflie_arplab");
        println!("{}", yaw_of(&log));
        println!("| part, s | Izz over the model's | brake, 1e-5 N m s | a rotor, 1e-8 kg m^2 | error of r, rad/s |");
        println!("|---|---|---|---|---|");
        for [without, with] in yaw_sizes(&log, &vehicle()) {
            print!("{without}{with}");
        }
    }
    println!("\n# Crazyflies with weights and cut propellers (CrazyPAD)\n");
    println!("| flight | thrust, % | V | roll, % | pitch, % | yaw, % |\n|---|---|---|---|---|---|");
    let flights = crazypad::flights();
    flights.iter().for_each(|flight| print!("{flight}"));
    println!("\n| changed | roll, % | pitch, % | yaw, % | pull to the motor, % | share of a weak motor |");
    println!("|---|---|---|---|---|---|");
    for (airframe, label) in crazypad::changed_labels(&flights) {
        let motor = if label.ends_with("M4") { crazypad::MOTOR_4 } else { crazypad::MOTOR_3 };
        let change = crazypad::Change::of(&flights, airframe, label, None);
        let pull_pct = change.pull_pct(motor);
        // a pull that normal flights have too has no share
        let is_pulled = pull_pct > change.normal_pct.iter().map(|normal| normal[1]).fold(0.0, f64::max);
        let share =
            if is_pulled { format!("{:.2}", change.weak_motor_shares(motor).last().unwrap()) } else { "-".into() };
        println!("| {airframe}, {label} |{change} {pull_pct:+.1} | {share} |");
    }
    print_baseline();
}

/// Prints what differs in each of CrazyPAD's flights from normal ones.
///
/// # Panics
/// The logs are there and can't be compared.
pub fn print_baseline() {
    println!("\n# CrazyPAD against normal flights of the airframe\n");
    println!("| flight | normal flights | departures, std | chance | answer |\n|---|---|---|---|---|");
    crazypad_baseline::compared(&crazypad_baseline::numbered("")).iter().for_each(|row| print!("{row}"));
}
