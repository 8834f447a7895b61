//! What of a log is predicted and compared, one by one.

use crate::axis::Axis;
use crate::log::Quantity;
use crate::prediction::body::{State, TURNING};

/// A measured quantity that the model predicts. Names are those of the log's columns without their unit.
///
/// | channels | names | unit for people | SI |
/// |---|---|---|---|
/// | Euler angles Z-Y-X | roll, pitch, yaw | deg | rad |
/// | body rates | p, q, r | deg/s | rad/s |
/// | specific force along the body's axes | ax, ay, az | m/s2 | m/s^2 |
/// | velocity north, east, down | vn, ve, vd | m/s | m/s |
/// | height of the rotors above ground | height | m | m |
///
/// A vehicle on a rig has angles and rates alone; one in free flight has all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// Euler angle.
    Angle(Axis),
    /// Body rate.
    Rate(Axis),
    /// Specific force along the body's x, y or z.
    Force(Axis),
    /// Velocity to the north, to the east or down.
    Velocity(Axis),
    /// Height above ground.
    Height,
}

impl Channel {
    /// All of them, in the order of every list of channels.
    pub const ALL: [Channel; 13] = {
        use Axis::{Pitch, Roll, Yaw};
        use Channel::{Angle, Force, Height, Rate, Velocity};
        [
            Angle(Roll),
            Angle(Pitch),
            Angle(Yaw),
            Rate(Roll),
            Rate(Pitch),
            Rate(Yaw),
            Force(Roll),
            Force(Pitch),
            Force(Yaw),
            Velocity(Roll),
            Velocity(Pitch),
            Velocity(Yaw),
            Height,
        ]
    };

    /// The column of a log that measures it; its plausible range is [`Quantity`]'s.
    pub fn quantity(self) -> Quantity {
        match self {
            Channel::Angle(axis) => Quantity::Angle(axis),
            Channel::Rate(axis) => Quantity::Rate(axis),
            Channel::Force(axis) => Quantity::Accel(axis),
            Channel::Velocity(axis) => Quantity::Velocity(axis),
            Channel::Height => Quantity::Height,
        }
    }

    /// Name in reports and JSON: roll, p, ax, vn, height, ...
    pub fn name(self) -> &'static str {
        self.quantity().stem()
    }

    /// Unit of its errors for people.
    pub fn unit(self) -> &'static str {
        match self {
            Channel::Angle(_) => "deg",
            Channel::Rate(_) => "deg/s",
            Channel::Force(_) => "m/s2",
            Channel::Velocity(_) => "m/s",
            Channel::Height => "m",
        }
    }

    /// A value in the unit for people.
    pub fn in_unit(self, value_si: f64) -> f64 {
        match self {
            Channel::Angle(_) | Channel::Rate(_) => value_si.to_degrees(),
            Channel::Force(_) | Channel::Velocity(_) | Channel::Height => value_si,
        }
    }

    /// What channels of one kind are called together.
    pub fn kind(self) -> &'static str {
        match self {
            Channel::Angle(_) => "Angles",
            Channel::Rate(_) => "Body rates",
            Channel::Force(_) => "Specific forces",
            Channel::Velocity(_) => "Velocities",
            Channel::Height => "Height",
        }
    }

    /// The axis about which it shows a rotation; none for what only a free vehicle has.
    pub fn turning_axis(self) -> Option<Axis> {
        match self {
            Channel::Angle(axis) | Channel::Rate(axis) => Some(axis),
            Channel::Force(_) | Channel::Velocity(_) | Channel::Height => None,
        }
    }

    /// The least noise that it is taken to have, SI: the rounding of logs and the accuracy of the integration.
    pub(crate) fn least_noise(self) -> f64 {
        match self {
            Channel::Angle(_) => 2e-5,
            Channel::Rate(_) => 2e-4,
            Channel::Force(_) => 2e-3,
            Channel::Velocity(_) | Channel::Height => 1e-4,
        }
    }

    /// The number of a state that it measures, which a window's start may choose; none for a force, which follows from
    /// the others. Rates of a state are those of the angles on the gimbal.
    pub(crate) fn of_state(self, state: &mut State) -> Option<&mut f64> {
        match self {
            Channel::Angle(axis) => state.get_mut(axis.index()),
            Channel::Rate(axis) => state.get_mut(3 + axis.index()),
            Channel::Force(_) => None,
            Channel::Velocity(axis) => state.get_mut(TURNING + axis.index()),
            Channel::Height => state.last_mut(),
        }
    }

    /// How far from the measured value a window's start state may be, SI: far beyond the error of any sensor.
    pub(crate) fn start_range(self) -> f64 {
        match self {
            Channel::Angle(_) => 0.5,
            Channel::Rate(_) | Channel::Force(_) | Channel::Velocity(_) | Channel::Height => 10.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;

    #[test]
    fn every_channel_is_a_column_of_its_own_and_bears_its_name() {
        for (index, channel) in Channel::ALL.into_iter().enumerate() {
            assert!(channel.quantity().name().starts_with(channel.name()), "{channel:?}");
            assert!(Quantity::ALL.contains(&channel.quantity()));
            assert!(Channel::ALL[index + 1..].iter().all(|other| other.quantity() != channel.quantity()));
        }
        let mut sorted = Channel::ALL;
        sorted.sort();
        assert_eq!(sorted, Channel::ALL);
        // a log's first height is found under the last channel
        let log = Log { height_m: Some(vec![1.5]), ..Log::default() };
        assert_eq!(log.column(Channel::Height.quantity()), Some(&[1.5][..]));
    }

    #[test]
    fn angles_are_shown_in_degrees_and_lengths_in_metres() {
        assert_eq!(Channel::Angle(Axis::Yaw).in_unit(core::f64::consts::PI), 180.0);
        assert_eq!(Channel::Velocity(Axis::Yaw).in_unit(2.0), 2.0);
        for channel in Channel::ALL {
            assert_eq!(channel.unit().starts_with("deg"), channel.turning_axis().is_some(), "{channel:?}");
            assert!(channel.least_noise() < 1e-3 * channel.start_range());
        }
    }
}
