//! `sil serve --simulator`: the loop between another program's simulator, the board and ground stations.

use std::net::{SocketAddr, ToSocketAddrs};
use std::time::{Duration, Instant};

use sil_host::serve::lock_step::{LockStep, PORT, SimulatorPort};
use sil_host::serve::{Pace, Sockets};

use super::{Failure, failed, print};

/// Wall time between two looks at the board's own clock while no simulator gives the time.
const NAP: Duration = Duration::from_millis(1);
/// Microseconds by the wall clock.
const WALL_TICK_US: u64 = 1;

/// The address of a simulator.
pub(super) fn simulator(text: &str) -> Result<SocketAddr, String> {
    let place = text.strip_prefix("tcp:").unwrap_or(text);
    if let Ok(port) = place.parse::<u16>() {
        return Ok(SocketAddr::from(([127, 0, 0, 1], port)));
    }
    let found = place.to_socket_addrs().ok().and_then(|mut addresses| addresses.next());
    found.ok_or_else(|| format!("expected where the simulator waits, as tcp:127.0.0.1:{PORT}"))
}

/// Until the simulated time is over.
pub(super) fn in_lock_step(
    end_us: u64,
    lock_step: &mut LockStep,
    port: &mut SimulatorPort,
    sockets: &mut Sockets,
) -> Result<(), Failure> {
    let mut pace = Pace::new(1.0, Instant::now());
    // by the wall clock, not yet made
    let mut due_us = 0;
    while lock_step.simulated_us() < end_us {
        sockets.receive(lock_step.board());
        let is_there = port.exchange(lock_step).map_err(failed)?;
        due_us += pace.take_due(Instant::now(), WALL_TICK_US);
        if lock_step.is_alone() {
            while due_us >= lock_step.board().step_us() {
                due_us -= lock_step.advance_alone().map_err(failed)?;
            }
        } else {
            due_us = 0;
        }
        sockets.send(&lock_step.board().take_sent());
        for line in [port.take_news(), lock_step.take_news(), sockets.take_news()].concat() {
            print(format!("{line}\n"))?;
        }
        if !is_there {
            std::thread::sleep(NAP);
        }
    }
    Ok(())
}
