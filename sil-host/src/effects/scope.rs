//! What a log can speak about, which decides what hypotheses it is given.

use super::Needs;
use crate::axis::Axis;
use crate::vehicle::Scale;

/// What a log and its rig can show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scope {
    /// How large the vehicle is.
    pub(crate) scale: Scale,
    /// True where four motors drive one body; false on separate axes.
    pub(crate) is_vehicle: bool,
    /// True where each motor's command is known, on separate axes too.
    pub(crate) has_motors: bool,
    /// True where what all motors do together changes enough to show how thrust grows with it.
    pub(crate) collective_varies: bool,
    /// Command of each motor under which a vehicle hovers, or is level on its rig.
    pub(crate) base_command: Option<f64>,
    /// True where its propulsion has rotors whose speed is known: not on level `box`, nor on separate axes.
    pub(crate) has_rotors: bool,
    /// True where a rig holds the vehicle, so that its angles show in the other axes though nobody measures them.
    pub(crate) is_held: bool,
    /// The log shows that nothing held what flew.
    pub(crate) shown_free: bool,
    /// True in free flight.
    pub(crate) flies_free: bool,
    /// Axes that the rig lets turn.
    pub(crate) turns: [bool; 3],
    /// Axes with a measured rate.
    pub(crate) rates: [bool; 3],
    /// Axes with a measured angle.
    pub(crate) angles: [bool; 3],
    /// True where the log has the battery's voltage.
    pub(crate) battery: bool,
    /// True where it shows what pushes a free vehicle.
    pub(crate) pushed: bool,
    /// True where it has a free vehicle's velocity.
    pub(crate) velocity: bool,
    /// True where it shows how the air passes what flies free, its vehicle known or not.
    pub(crate) airspeed: bool,
    /// A free vehicle's height above ground in the first row, m.
    pub(crate) height_m: Option<f64>,
}

#[cfg(test)]
impl Scope {
    /// Three axes by themselves on a bench, with angles and rates and nothing else.
    pub(crate) const OF_AXES: Scope = Scope {
        scale: Scale::SEPARATE_AXES,
        is_vehicle: false,
        has_motors: false,
        collective_varies: false,
        base_command: None,
        has_rotors: false,
        is_held: true,
        shown_free: false,
        flies_free: false,
        turns: [true; 3],
        rates: [true; 3],
        angles: [true; 3],
        battery: false,
        pushed: false,
        velocity: false,
        airspeed: false,
        height_m: None,
    };
}

impl Scope {
    /// Axes that turn, and of which the log shows angle or rate.
    pub(super) fn turning_axes(&self) -> impl Iterator<Item = Axis> + use<> {
        let seen: [bool; 3] = core::array::from_fn(|i| self.turns[i] && (self.rates[i] || self.angles[i]));
        Axis::ALL.into_iter().filter(move |axis| seen[axis.index()])
    }

    /// Roll and pitch of these: gravity knows no yaw.
    pub(super) fn tilting_axes(&self) -> impl Iterator<Item = Axis> + use<> {
        self.turning_axes().filter(|axis| *axis != Axis::Yaw)
    }

    /// Roll and pitch, as far as something may hold them by their angle: of a vehicle that the log shows flying free
    /// nothing does, also where it is not known and its axes are taken one by one.
    pub(super) fn borne_axes(&self) -> impl Iterator<Item = Axis> + use<> {
        let is_borne = self.flies_free || !self.shown_free;
        self.tilting_axes().filter(move |_| is_borne)
    }

    /// Axes whose gyro can be checked: with nothing to compare it with a gyro is right, for a bias then changes
    /// nothing, and a scale is an inertia's.
    pub(super) fn gyro_axes(&self) -> impl Iterator<Item = Axis> + use<> {
        let seen: [bool; 3] = core::array::from_fn(|i| self.rates[i] && (self.angles[i] || self.is_held));
        Axis::ALL.into_iter().filter(move |axis| seen[axis.index()])
    }

    /// True where the log shows an axis' angle, or a rig lets it show in others.
    pub(super) fn knows_angle(&self, axis: Axis) -> bool {
        self.angles[axis.index()] || self.is_held
    }

    /// True where the log shows what an effect needs.
    pub(crate) fn has(&self, needs: Needs) -> bool {
        match needs {
            Needs::Push => self.pushed,
            Needs::Velocity => self.velocity,
            Needs::Airspeed => self.airspeed,
            Needs::Height => self.height_m.is_some(),
        }
    }
}
