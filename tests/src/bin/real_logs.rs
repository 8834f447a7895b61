//! The tables of docs/real-logs.md: `cargo run --release -p integration-tests --bin real_logs`. The logs are looked for in `$SIL_DATA`.

use integration_tests::real_logs::crazyflie::vehicle;
use integration_tests::real_logs::crazyflie_table::{RollPitch, yaw_of};
use integration_tests::real_logs::{bench, crazypad, files, folder, load};

fn main() {
    if folder().is_none() {
        return;
    }
    println!("# Bench with a free pitch (ANT-X)\n");
    println!("| run | pitch, deg: nominal, extended | q, deg/s: nominal, extended | findings |\n|---|---|---|---|");
    for path in files("rig_antx_2dof", "Lab") {
        print!("{}", bench::Run::of(&path));
    }
    println!("\n# Crazyflie flown for identification (ARP lab)\n");
    for path in files("flight_crazyflie_arplab", "log15") {
        println!("{}", RollPitch::of(&load(&path, "crazyflie_arplab"), &vehicle()));
    }
    for path in files("flight_crazyflie_arplab", "log16") {
        print!("{}", yaw_of(&load(&path, "crazyflie_arplab")));
    }
    println!("\n# Crazyflie with a weight near motor 3 (CrazyPAD)\n");
    println!("| flight | mean command | V | roll, % of the lift | pitch | yaw |\n|---|---|---|---|---|---|");
    let flights: Vec<crazypad::Steady> =
        files("flight_crazypad", "").iter().flat_map(|path| crazypad::steady(path, &vehicle())).collect();
    flights.iter().for_each(|flight| print!("{flight}"));
    print!("{}", crazypad::Change::of(&flights));
}
