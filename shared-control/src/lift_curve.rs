//! Static map between a motor's command and its lift, both ways, by linear interpolation in a table.
//!
//! The slope of the real curve falls by a factor of three from low to high command, so a mixer that took it for a
//! straight line would change the loop gain by as much. The table comes from the vehicle's model file.

/// Intervals in the table.
pub const LIFT_INTERVALS: usize = 32;

/// Command needed for equally spaced lifts from `lift_min_n` (command 0) to `lift_max_n` (command 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftCurve {
    /// Lift at command 0, N.
    pub lift_min_n: f32,
    /// Lift at command 1, N.
    pub lift_max_n: f32,
    /// Command 0..1 at lift_min + k / LIFT_INTERVALS * (lift_max - lift_min); strictly increasing.
    pub command_at: [f32; LIFT_INTERVALS + 1],
}

impl LiftCurve {
    /// A straight line from no lift at command 0.
    pub fn straight(lift_max_n: f32) -> Self {
        Self { lift_min_n: 0.0, lift_max_n, command_at: core::array::from_fn(|k| k as f32 / LIFT_INTERVALS as f32) }
    }

    /// Command for a lift; lifts outside the range get the nearest end.
    pub fn command(&self, lift_n: f32) -> f32 {
        let position = (lift_n - self.lift_min_n) / (self.lift_max_n - self.lift_min_n) * LIFT_INTERVALS as f32;
        let position = crate::elementary::limit(position, 0.0, LIFT_INTERVALS as f32);
        let interval = (position as usize).min(LIFT_INTERVALS - 1);
        let (low, high) = (self.command_at[interval], self.command_at[interval + 1]);
        low + (high - low) * (position - interval as f32)
    }

    /// Lift of a command; the exact inverse of [`Self::command`].
    pub fn lift(&self, command: f32) -> f32 {
        let interval_n = (self.lift_max_n - self.lift_min_n) / LIFT_INTERVALS as f32;
        // a loop with constant bounds: the compiler sees that no index is out of range, so no panic is linked
        for interval in 0..LIFT_INTERVALS {
            let (low, high) = (self.command_at[interval], self.command_at[interval + 1]);
            if command < high || interval == LIFT_INTERVALS - 1 {
                let share = crate::elementary::limit((command - low) / (high - low), 0.0, 1.0);
                return self.lift_min_n + (interval as f32 + share) * interval_n;
            }
        }
        self.lift_max_n
    }

    /// The part of it from a command on, with its lifts equally spaced again: of a motor that must not turn slower.
    /// All of it where that command is 0, or no number.
    pub fn from_command(&self, command_min: f32) -> Self {
        if !(command_min > 0.0 && command_min < 1.0) {
            return *self;
        }
        let lift_min_n = self.lift(command_min);
        let interval_n = (self.lift_max_n - lift_min_n) / LIFT_INTERVALS as f32;
        let mut part = Self { lift_min_n, ..*self };
        for (interval, command) in part.command_at.iter_mut().enumerate() {
            // both ends exactly, whatever rounding makes of them
            *command = match interval {
                0 => command_min,
                LIFT_INTERVALS => 1.0,
                _ => self.command(lift_min_n + interval as f32 * interval_n),
            };
        }
        part
    }

    /// True if lift and command rise together over the whole table.
    pub fn is_increasing(&self) -> bool {
        self.lift_max_n > self.lift_min_n && self.command_at.windows(2).all(|pair| pair[1] > pair[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square_root_curve() -> LiftCurve {
        // lift = command^2 * 4 N
        LiftCurve {
            lift_min_n: 0.0,
            lift_max_n: 4.0,
            command_at: core::array::from_fn(|k| crate::elementary::sqrt(k as f32 / LIFT_INTERVALS as f32)),
        }
    }

    proptest! {
        #[test]
        fn lift_and_command_are_inverse(command in 0f32..=1.0) {
            let curve = square_root_curve();
            prop_assert!((curve.command(curve.lift(command)) - command).abs() < 1e-5);
        }
    }

    proptest! {
        /// The part from a command on begins there, and between is the same curve, to what a line between two points
        /// of it differs from two lines: most where the whole's first two meet, with slopes of 0.71 and 1.71 N. A line
        /// over 0.122 N of lift across that corner leaves it by 0.0265 N at most.
        #[test]
        fn a_part_of_the_curve_is_the_curve(command_min in 0.01f32..0.5, share in 0f32..=1.0) {
            let (whole, part) = (square_root_curve(), square_root_curve().from_command(command_min));
            prop_assert!(part.is_increasing());
            prop_assert_eq!((part.command_at[0], part.command_at[LIFT_INTERVALS]), (command_min, 1.0));
            prop_assert_eq!((part.lift(0.0), part.lift_max_n), (whole.lift(command_min), whole.lift_max_n));
            let command = command_min + share * (1.0 - command_min);
            prop_assert!((part.lift(command) - whole.lift(command)).abs() < 0.027, "{command}");
            prop_assert!((part.command(part.lift(command)) - command).abs() < 1e-5);
        }
    }

    #[test]
    fn without_a_least_command_the_curve_stays_whole() {
        for command_min in [0.0, -1.0, f32::NAN, 1.0] {
            assert_eq!(square_root_curve().from_command(command_min), square_root_curve());
        }
    }

    #[test]
    fn ends_are_exact_and_nan_is_tame() {
        let curve = square_root_curve();
        assert_eq!(curve.command(-1.0), 0.0);
        assert_eq!(curve.command(9.0), 1.0);
        assert_eq!(curve.command(f32::NAN), 0.0);
        assert_eq!(curve.lift(1.0), 4.0);
        assert_eq!(curve.lift(2.0), 4.0);
        assert_eq!(curve.lift(-1.0), 0.0);
        assert!(curve.lift(f32::NAN).is_finite());
    }

    #[test]
    fn a_curve_that_is_flat_anywhere_is_not_increasing() {
        let curve = square_root_curve();
        assert!(curve.is_increasing());
        assert!(!LiftCurve { lift_min_n: 4.0, ..curve }.is_increasing(), "no span");
        assert!(!LiftCurve { lift_min_n: 5.0, ..curve }.is_increasing());
        for k in [1, 20, LIFT_INTERVALS] {
            let mut flat = curve;
            flat.command_at[k] = flat.command_at[k - 1];
            assert!(!flat.is_increasing(), "interval {k}");
        }
    }
}
