//! The fields of `sil thesis --json` (docs/commands.md).

use serde::Serialize;

use super::fidelity;
use crate::thesis::printed::PrintedConstant;
use crate::thesis::{Claim, CopterRow, Deviation, HorizonRow, LateRow, RING_MOMENT_NM, Reproduction};

/// All of it.
#[derive(Serialize)]
pub struct ThesisJson {
    ring_moment_nm: f64,
    table_5_1: Vec<FidelityJson>,
    copter: CopterJson,
    late_log: Vec<LateRow>,
    horizons: Vec<HorizonRow>,
    claims: Vec<Claim>,
    constants: Vec<PrintedConstant>,
}

#[derive(Serialize)]
struct FidelityJson {
    controller: String,
    printed_deg: Option<[f64; 2]>,
    here: Deviation,
}

#[derive(Serialize)]
struct CopterJson {
    integral_max_nm: f64,
    rate_factor: Option<f64>,
    rows: Vec<CopterRow>,
}

impl ThesisJson {
    /// Of what was flown.
    pub fn of(of: &Reproduction) -> Self {
        let rows = fidelity(of).into_iter().map(|row| FidelityJson {
            controller: row.controller,
            printed_deg: row.printed_deg,
            here: row.here,
        });
        Self {
            ring_moment_nm: RING_MOMENT_NM,
            table_5_1: rows.collect(),
            copter: CopterJson {
                integral_max_nm: of.integral_max_nm,
                rate_factor: of.rate_factor,
                rows: of.copter_rows.clone(),
            },
            late_log: of.late.clone(),
            horizons: of.horizons.clone(),
            claims: of.claims.clone(),
            constants: of.constants.clone(),
        }
    }
}
