//! Whose motor is which of ours: the four rotors of an X by where they stand and how they turn; and vehicles that have
//! other rotors.

use super::recording::FactValue;
use shared_control::airframe::MOTORS;

/// A rotor of somebody's numbering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rotor {
    /// In front of the pitch axis.
    pub(super) is_front: bool,
    /// To the right of the roll axis.
    pub(super) is_right: bool,
    /// Counter-clockwise, seen from above.
    pub(super) is_counter_clockwise: bool,
}

impl Rotor {
    /// In words, as docs/rig.md says it.
    pub(super) fn in_words(self) -> String {
        let [depth, side] =
            [["rear", "front"][usize::from(self.is_front)], ["left", "right"][usize::from(self.is_right)]];
        let spin = ["clockwise", "counter-clockwise"][usize::from(self.is_counter_clockwise)];
        format!("{depth} {side}, {spin}")
    }
}

/// What the fact `spin` says where all rotors turn the other way than ours do.
pub(super) fn spin_reversed() -> FactValue {
    let said = "the rotors turn the other way than docs/rig.md's: yaw answers to the motors with the other sign";
    FactValue::Text(said.to_owned())
}

/// Why a log of another vehicle is refused: the parameter that says what it is, and what that is called where it is
/// known.
pub(super) fn no_quadrotor(parameter: &str, value: f64, called: Option<&str>) -> String {
    let called = called.map(|called| format!(", {called}")).unwrap_or_default();
    format!(
        "the vehicle is no quadrotor: its parameter {parameter} is {value}{called}; only quadrotors are simulated, and \
         if it is one all the same, a --map that names the fields reads it"
    )
}

/// Which of our motors four rotors are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotorOrder {
    /// For each of our motors, which of the given rotors it is.
    pub(super) given: [usize; 4],
    /// True if all turn the other way than ours do, so that yaw answers the other way.
    pub(super) is_spin_reversed: bool,
}

impl MotorOrder {
    /// Of four rotors.
    ///
    /// # Errors
    /// In words: two stand in the same corner, or they turn as no quad-X's do.
    pub(super) fn of(rotors: &[Rotor; 4]) -> Result<MotorOrder, String> {
        let (mut given, mut reversed) = ([0; 4], 0);
        for (ours, motor) in MOTORS.iter().enumerate() {
            let is_here = |rotor: &Rotor| (rotor.is_front, rotor.is_right) == (motor.forward > 0, motor.right > 0);
            let place = rotors.iter().position(is_here);
            given[ours] = place.ok_or_else(|| "two rotors stand in the same corner".to_owned())?;
            reversed += usize::from(rotors[given[ours]].is_counter_clockwise != (motor.spin < 0));
        }
        match reversed {
            0 | 4 => Ok(MotorOrder { given, is_spin_reversed: reversed == 4 }),
            _ => Err("neighbouring rotors turn the same way".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ours() -> [Rotor; 4] {
        MOTORS.map(|motor| Rotor {
            is_front: motor.forward > 0,
            is_right: motor.right > 0,
            is_counter_clockwise: motor.spin < 0,
        })
    }

    #[test]
    fn any_order_of_our_rotors_is_undone_and_the_other_spin_is_seen() {
        for first in 0..4 {
            for second in (0..4).filter(|second| *second != first) {
                let rest: Vec<usize> = (0..4).filter(|rotor| ![first, second].contains(rotor)).collect();
                let order = [first, second, rest[0], rest[1]];
                let rotors = order.map(|motor| ours()[motor]);
                let found = MotorOrder::of(&rotors).unwrap();
                assert_eq!(found.given.map(|rotor| order[rotor]), [0, 1, 2, 3]);
                assert!(!found.is_spin_reversed);
                let turned = rotors.map(|rotor| Rotor { is_counter_clockwise: !rotor.is_counter_clockwise, ..rotor });
                assert_eq!(MotorOrder::of(&turned).unwrap(), MotorOrder { is_spin_reversed: true, ..found });
            }
        }
    }

    #[test]
    fn what_is_no_quad_x_is_refused() {
        let mut twice = ours();
        twice[1] = twice[0];
        assert!(MotorOrder::of(&twice).unwrap_err().contains("same corner"));
        let mut one_turned = ours();
        one_turned[2].is_counter_clockwise = true;
        assert!(MotorOrder::of(&one_turned).unwrap_err().contains("same way"));
    }
}
