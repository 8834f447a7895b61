//! An IMU that is turned about the body's z axis. Positive turns its x axis from forward to right: it reports
//! `p c + q s`, `-p s + q c`, the specific force likewise, and the attitude of `R_wb Rz(yaw)`.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// An IMU that is turned about the vertical axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuMisalignment {
    /// Angle of the sensor about the body's z axis, rad.
    pub yaw_rad: f64,
}

const YAW: Parameter = Parameter::new(
    "yaw_rad",
    "rad",
    "angle of the sensor about the body's z axis, its x axis turned to the right",
    [-3.2, 3.2],
);

impl Catalogued for ImuMisalignment {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "imu_misalignment",
        origin: Origin::Sensor,
        acts_on: ActsOn::Vehicle,
        parameters: &[YAW],
        summary: "IMU turned about the body's z axis",
        statement: "the sensor is turned about the vertical axis of the body",
        equation: "p_rep = c p + s q, q_rep = -s p + c q, specific force likewise; the angles are those of R_wb \
                   Rz(yaw_rad)",
        example: "imu_misalignment:yaw_rad=0.05",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { yaw_rad: given.number(&YAW)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let yaw = Unknown::of(&YAW, 1e-5).within(-1.6, 1.6);
        let of_vehicle = || Hypothesis::new(Self::ENTRY, [yaw], |[yaw_rad]| Self { yaw_rad });
        scope.is_vehicle.then(of_vehicle).into_iter().collect()
    }
}

impl Extension for ImuMisalignment {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("yaw_rad", self.yaw_rad)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.sensors.yaw_rad += self.yaw_rad;
    }
}
