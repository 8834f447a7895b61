//! The thesis flown again: every table of its chapters 3 to 5 and of appendix C, and what its figures 5.3 to 5.6 show,
//! beside the printed numbers, and why ours differ where they do.
//!
//! ```text
//!   printed       constants and deviations as printed, beside the models that ship
//!   testbed       its MPC; the ring off balance, in place of the rig that nobody has any more
//!   copter_cascade  APM:Copter's gains and its limit of the integral, in this project's numbers
//!   fidelity      simulated against tested, table 5.1
//!   claims        what the text says
//! ```

mod claims;
pub mod copter_cascade;
mod fidelity;
pub mod printed;
mod testbed;

pub use claims::{Claim, HorizonRow, Verdict, real_lag_s};
pub use fidelity::{CopterRow, Deviation, LateRow, Pair};
pub use testbed::{RING_MOMENT_NM, off_balance, thesis_mpc};

use shared_control::config::Controller;

use self::copter_cascade::{IntegralLimit, copter_cascade, integral_max_nm};
use self::printed::{PrintedConstant, TABLE_5_1_PID_DEG, constants};
use crate::controller_file::{ControllerChoice, ControllerFileError};
use crate::flight::SetupError;
use crate::model::{Rig, VehicleModel};

/// A flight that this needs can't begin; none such ships.
#[derive(Debug, thiserror::Error)]
pub enum ThesisError {
    /// The thesis' MPC is no controller file.
    #[error(transparent)]
    File(#[from] ControllerFileError),
    /// A controller is refused.
    #[error(transparent)]
    Setup(#[from] SetupError),
}

/// All of it.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// Tables 3.3, 3.4, C.1 to C.3.
    pub constants: Vec<PrintedConstant>,
    /// The thesis' MPC.
    pub mpc: Pair,
    /// This project's cascade.
    pub cascade: Pair,
    /// Copter's cascade, with the factor that explains table 5.1 or, if there is none, with its own gains.
    pub copter: Pair,
    /// That factor.
    pub rate_factor: Option<f64>,
    /// Copter's cascade with other factors.
    pub copter_rows: Vec<CopterRow>,
    /// Torque at which its integral ends, N m.
    pub integral_max_nm: f64,
    /// What a log that begins late does to table 5.1.
    pub late: Vec<LateRow>,
    /// The MPC with other horizons.
    pub horizons: Vec<HorizonRow>,
    /// What the text says.
    pub claims: Vec<Claim>,
}

/// Flies it all again.
///
/// # Errors
/// [`ThesisError`]: none of what ships is refused.
pub fn reproduce() -> Result<Reproduction, ThesisError> {
    let (testbed, mpc_choice) = (VehicleModel::nominal(Rig::Gimbal), thesis_mpc()?);
    let pid = ControllerChoice::nominal(Controller::Cascade);
    let (mpc, cascade) = (Pair::fly(mpc_choice)?, Pair::fly(pid)?);
    let copter_rows = fidelity::copter_rows()?;
    let [_, pitch_deg] = TABLE_5_1_PID_DEG;
    let rate_factor = fidelity::factor_for(pitch_deg, &copter_rows)?;
    let copter = Pair::fly(copter_cascade(&testbed, rate_factor.unwrap_or(1.0), IntegralLimit::Copter))?;
    let horizons = claims::horizon_rows(mpc_choice)?;
    let claims = claims::claims([&mpc, &copter, &cascade], &horizons, pid)?;
    Ok(Reproduction {
        constants: constants(),
        late: fidelity::late_rows(&mpc, &cascade),
        integral_max_nm: integral_max_nm(&testbed),
        mpc,
        cascade,
        copter,
        rate_factor,
        copter_rows,
        horizons,
        claims,
    })
}
