//! What is asked of a log: the nominal model of what made it, what that leaves to each log, and which hypotheses the log can speak about.

use super::effects::input_gain::InputGain;
use super::effects::{Scope, apply_known};
use super::verdict::Rejected;
use crate::axis::Axis;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::log::Log;
use crate::prediction::body::Body;
use crate::prediction::force_track::Drive;
use crate::prediction::model::Model;
use crate::prediction::windowed_log::WindowedLog;
use crate::prediction::{Channel, MeasuredNoise, NotPredictable, Subject};

impl Subject<'_> {
    /// The nominal model, with the effects that it is known to have.
    pub(super) fn model(&self) -> Model {
        match self {
            Subject::Vehicle(vehicle) => {
                let mut model = Model::nominal(Drive::of(vehicle), Body::of(vehicle));
                vehicle.effects.iter().for_each(|known| apply_known(known, &mut model));
                model
            }
            Subject::Axes => Model::nominal(Drive::Direct, Body::axes([0.0; 3])),
        }
    }

    /// What the nominal model leaves to each log: the input gains of separate axes.
    ///
    /// # Errors
    /// An axis' command is zero in every window: its gain can't be found.
    pub(super) fn fitted_along(&self, log: &WindowedLog<'_>) -> Result<Vec<InputGain>, NotPredictable> {
        let Subject::Axes = self else { return Ok(Vec::new()) };
        let axes: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| log.turns(*axis)).collect();
        for axis in &axes {
            let in_windows = log.windows.iter().flat_map(|window| log.commands_between(window.start, window.end));
            if in_windows.into_iter().all(|command| command[axis.index()] == 0.0) {
                return Err(NotPredictable::NoExcitation { axis: axis.name() });
            }
        }
        Ok(axes.into_iter().map(InputGain).collect())
    }

    /// What hypotheses make sense.
    pub(super) fn scope(&self, log: &Log) -> Scope {
        let turns = self.turns(log);
        let vehicle = matches!(self, Subject::Vehicle(_));
        let compared = self.compared(log).channels;
        let is_seen = |channel: Channel| log.column(channel.quantity()).is_some() && compared.contains(&channel);
        let rates = Axis::ALL.map(|axis| is_seen(Channel::Rate(axis)));
        let angles = Axis::ALL.map(|axis| is_seen(Channel::Angle(axis)));
        let has_velocity = log.velocity_ned_m_s.iter().all(Option::is_some);
        Scope {
            axes: [0, 1, 2].map(|axis: usize| rates[axis] || angles[axis]),
            rates,
            angles,
            turns,
            motors: vehicle,
            battery: log.battery_v.is_some(),
            coupled: vehicle,
            is_held: self.is_held(),
            flies_free: self.flies_free(),
            pushed: self.flies_free() && (log.accel_body_m_s2[2].is_some() || has_velocity),
            velocity: self.flies_free() && has_velocity,
            height: self.flies_free().then(|| log.height_m.as_ref()?.first().copied()).flatten(),
        }
    }

    /// What a log of free flight can't be asked, for want of columns.
    pub(super) fn not_asked(&self, log: &Log) -> Vec<Rejected> {
        let scope = self.scope(log);
        let wanting = |is_asked: bool, effects: &[&'static str], reason: &str| -> Vec<Rejected> {
            let effects = effects.iter().filter(|_| !is_asked && self.flies_free());
            effects.map(|effect| Rejected { effect, axis: String::new(), reason: reason.to_owned() }).collect()
        };
        [
            wanting(
                scope.pushed,
                &["mass_error"],
                "not asked: the log has neither az_m_s2 nor vn_m_s, ve_m_s and vd_m_s",
            ),
            wanting(scope.velocity, &["rotor_drag", "wind"], "not asked: the log lacks vn_m_s, ve_m_s and vd_m_s"),
            wanting(scope.height.is_some(), &["ground_effect"], "not asked: the log lacks height_m"),
        ]
        .concat()
    }

    /// The log in windows, to be fitted under the sensors' noise alone.
    ///
    /// # Errors
    /// As [`Subject::windowed`].
    pub(super) fn shooting<'l>(&self, log: &'l Log, noise: &MeasuredNoise) -> Result<Shooting<'l>, NotPredictable> {
        Ok(Shooting::new(self.windowed(log, noise)?))
    }
}
