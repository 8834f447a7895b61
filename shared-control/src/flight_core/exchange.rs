//! Another configuration in place of the one in use, between two steps: on the ground, or what was learnt.

use super::FlightCore;
use super::state::State;
use crate::config::Config;
use crate::learning::lesson::Taught;
use crate::supervisor::Arming;

impl FlightCore {
    /// Takes another configuration from the next step on. What was measured stays where the same sensors go on to be
    /// read in the same way: attitude, the gyro's bias, whether the vehicle stands. What the controllers had in mind is
    /// forgotten. Sensors that are read in another way are new ones, and stand still before they are believed.
    ///
    /// False, and nothing has changed, unless the vehicle is disarmed: no exchange is shown to be without a jump, and
    /// stable from wherever a flight may be.
    pub fn exchange(config: &mut Config, state: &mut State, next: &Config) -> bool {
        if !matches!(state.arming, Arming::Disarmed(_)) {
            return false;
        }
        let same_sensors =
            config.sensing.imu == next.sensing.imu && config.sensing.imu_second == next.sensing.imu_second;
        let same_battery = config.supervisor.battery == next.supervisor.battery;
        // taken apart, so that a new field does not compile until it stands in one group
        let State {
            imus,
            estimator,
            coasting,
            battery,
            angle,
            rate,
            rate_target,
            observer,
            motor_loss,
            learning,
            exchanges,
            learnt_model,
            taught: _,
            // of the vehicle and the world, or of a step that turned no motor
            step: _,
            arming: _,
            setpoint: _,
            planning: _,
            watch: _,
            touchdown: _,
            battery_seen: _,
            last_wrench: _,
            last_mix: _,
            last_source: _,
        } = state;
        if !same_sensors {
            (*imus, *estimator, *coasting) = Default::default();
        }
        if !same_battery {
            *battery = Default::default();
        }
        (*angle, *rate, *rate_target, *observer) = Default::default();
        (*motor_loss, *learning, *learnt_model) = Default::default();
        *exchanges = exchanges.wrapping_add(1);
        *config = *next;
        true
    }

    /// Takes what was made of what a flight taught, from the next step on, in flight too. All that passes from step to
    /// step is in SI units and means the same to the other controller, whose MPC comes with it.
    pub fn learn(config: &mut Config, state: &mut State, taught: &Taught) {
        let Taught { step, model, angle, rate, inertia_kg_m2, observer, pitch_inertia } = *taught;
        *config = Config { angle, rate, inertia_kg_m2, observer, pitch_inertia, ..*config };
        let [times, _] = state.taught;
        state.taught = [times.wrapping_add(1), step];
        state.learnt_model = Some(model);
    }
}
