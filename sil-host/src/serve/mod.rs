//! A simulated vehicle that ground stations connect to: the board's parts of the core around the plant, in real time.
//!
//! ```text
//!   sockets -> bytes -> SimulatedBoard (receiver, commander, FlightCore, telemetry) -> bytes -> sockets
//!                          ^  samples                     | commands
//!                          '------ World (plant, sensors, what holds the vehicle) <'
//! ```
//! Everything but the sockets goes by simulated time: [`ServedVehicle::advance`] makes the steps that are due, and wall
//! time only says how many that are (`pace.rs`). What arrives is taken between two steps, as on the board.

mod board;
mod board_log;
pub mod lock_step;
mod log_shelf;
mod pace;
pub mod parameter_file;
pub mod signing_file;
mod sockets;
mod support;
mod world;

pub use board::{GivenRates, Memory, OutOfOrder, ParameterStore, SigningStore, SimulatedBoard, Unsigned};
pub use log_shelf::LogShelf;
pub use pace::Pace;
pub use sockets::{Sockets, SocketsSetup};

use shared_control::params::Params;

use crate::model::VehicleModel;
use world::World;

/// Both clocks, of the loop (2.5 or 10 ms) and of the IMU (1 ms), tick at multiples of this, µs.
pub const TICK_US: u64 = 500;
/// A sample of the IMU, µs.
const SAMPLE_US: u64 = 1_000_000 / shared_control::setup::IMU_RATE_HZ as u64;
/// Housekeeping, as often as on the board, µs.
const HOUSEKEEPING_US: u64 = 10_000;

/// A board and the vehicle that it flies.
pub struct ServedVehicle {
    model: VehicleModel,
    seed: u64,
    board: SimulatedBoard,
    world: World,
    /// Since the board's last start.
    now_us: u64,
    /// All that was simulated, µs.
    simulated_us: u64,
    restarts: u32,
}

impl ServedVehicle {
    /// Stands on its legs, or hangs level in its rig; the board has just started.
    ///
    /// # Errors
    /// [`OutOfOrder`] where the parameters cannot be flown.
    pub fn new(model: VehicleModel, seed: u64, params: &Params, memory: Memory) -> Result<Self, OutOfOrder> {
        let board = SimulatedBoard::start(params, memory)?;
        let world = World::new(&model, seed);
        Ok(Self { model, seed, board, world, now_us: 0, simulated_us: 0, restarts: 0 })
    }

    /// The board, for whoever has bytes for it.
    pub fn board(&mut self) -> &mut SimulatedBoard {
        &mut self.board
    }

    /// The simulated vehicle as it truly is.
    pub fn truth(&self) -> crate::plant::Truth {
        self.world.truth()
    }

    /// All that was simulated, µs.
    pub fn simulated_us(&self) -> u64 {
        self.simulated_us
    }

    /// How often the board was started anew by command.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }

    /// On by a tick: the samples, steps and reports that are due then. A board that was told to start anew does, with
    /// the vehicle where it was at first.
    ///
    /// # Errors
    /// [`OutOfOrder`] where the parameters that it starts with cannot be flown.
    pub fn advance(&mut self) -> Result<(), OutOfOrder> {
        if self.now_us.is_multiple_of(SAMPLE_US) {
            self.board.sample(self.world.sample(self.now_us));
        }
        if self.now_us.is_multiple_of(self.board.step_us()) {
            let driven = self.board.step(self.now_us, Some(self.world.battery_v()));
            self.world.drive(&driven);
        }
        if self.now_us.is_multiple_of(HOUSEKEEPING_US) {
            self.board.keep_house(self.now_us);
        }
        self.world.advance(TICK_US);
        self.now_us += TICK_US;
        self.simulated_us += TICK_US;
        if self.board.wants_restart() {
            self.board.restart()?;
            self.world = World::new(&self.model, self.seed);
            self.now_us = 0;
            self.restarts += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
