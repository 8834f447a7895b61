//! From raw counts to the attitude, for two IMUs, and the battery's voltage.
//!
//! ```text
//!   RawImuSample[] of each IMU
//!     --imu: SI units, body axes, rotor_notches, low-pass------> ImuStep ---.
//!     --imu_health: are the raw words to be believed?--> ImuHealth --------+--> imu_select: one of the two
//!     --gyro_bias: what its gyro reads at rest--> bias --------------------'         |
//!          AttitudeEstimate <--estimator, in flight with levelling: what should be felt--'
//! ```

pub mod battery;
pub mod estimator;
pub mod gyro_bias;
pub mod imu;
pub mod imu_health;
pub mod imu_select;
pub mod level_trim;
pub mod levelling;
pub mod rotor_notches;
