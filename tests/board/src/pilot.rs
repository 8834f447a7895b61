//! A pilot of a free vehicle, by the transmitter's sticks. The height is kept by eye, as a person would: there is no
//! height sensor on the board.

use crate::flight::{Flight, MILLISECOND};
use crate::time::Ticks;
use crate::transmitter::Transmitter;

/// Channels of the sticks.
pub const ROLL: usize = 1;
/// The same.
pub const PITCH: usize = 2;
/// The same.
pub const THROTTLE: usize = 3;
/// The same.
pub const YAW: usize = 4;
/// A stick in its middle, us.
pub const MIDDLE_US: u16 = 1500;
/// A stick half way to its end, dead zone counted, us: 15 degrees of tilt.
pub const HALF_US: u16 = 1755;
/// From power-on to a gyro that is calibrated.
const START: Ticks = 3500 * MILLISECOND;

impl Flight {
    /// From power-on: with a transmitter, armed by its sticks, idling on the ground.
    ///
    /// # Panics
    /// If it does not arm, or leaves the ground.
    pub fn arm_from_power_on(&mut self) {
        self.transmitter = Some(Transmitter::new());
        self.run_for(START);
        self.arm_by_sticks();
    }

    /// Armed by the sticks, idling on the ground.
    ///
    /// # Panics
    /// If it does not arm, or leaves the ground.
    pub fn arm_by_sticks(&mut self) {
        self.set_stick(YAW, 2000);
        self.run_for(1500 * MILLISECOND);
        assert!(self.is_armed(), "{:?}", self.ground.texts());
        self.set_stick(YAW, MIDDLE_US);
        self.run_for(300 * MILLISECOND);
        assert!(self.vehicle.borrow().is_down(), "it idles on the ground");
    }

    /// The pilot brings it to a height and keeps it there, about the throttle that the board takes for hovering.
    ///
    /// # Panics
    /// If the board stops, or a bit differs.
    pub fn fly_at(&mut self, height_m: f64, duration_ms: u64) {
        let hover = f64::from(self.params().hover_throttle_permille) / 1000.0;
        let end = self.machine.now() + duration_ms * MILLISECOND;
        while self.machine.now() < end {
            let (height, climb_m_s) = self.vehicle.borrow().height();
            let climb_wanted_m_s = (0.8 * (height_m - height)).clamp(-0.7, 1.0);
            let throttle = hover + (0.12 * (climb_wanted_m_s - climb_m_s)).clamp(-0.15, 0.15);
            self.set_stick(THROTTLE, (1010.0 + 990.0 * throttle) as u16);
            self.run_for(20 * MILLISECOND);
        }
    }

    /// From the ground to this height, with the time to settle there.
    ///
    /// # Panics
    /// If it does not get there.
    pub fn take_off_to(&mut self, height_m: f64) {
        self.fly_at(height_m, (500.0 + 1500.0 * height_m) as u64);
        let (reached_m, _) = self.vehicle.borrow().height();
        assert!((height_m - reached_m).abs() < 0.5, "{reached_m} m");
    }

    /// Down to the ground and disarmed by the sticks.
    ///
    /// # Panics
    /// If it does not come down, or falls over.
    pub fn land(&mut self) {
        let (mut left, before) = (500, self.vehicle.borrow().touched_down().len());
        while !self.vehicle.borrow().is_down() {
            self.fly_at(-1.0, 20);
            left -= 1;
            assert!(left > 0, "does not come down: {:?}", self.vehicle.borrow().height());
        }
        // it may bounce
        let touched_down = self.vehicle.borrow().touched_down()[before];
        println!("touches down at {:.2} m/s, {:.1} deg", touched_down.speed_m_s, touched_down.tilt_rad.to_degrees());
        assert!(touched_down.stands() && touched_down.speed_m_s < 1.5, "{touched_down:?}");
        self.set_stick(THROTTLE, 1000);
        self.run_for(2000 * MILLISECOND);
        self.set_stick(YAW, 1000);
        self.run_for(1300 * MILLISECOND);
        assert!(!self.is_armed(), "disarmed by the sticks once it has landed");
    }

    /// True roll and pitch, degrees.
    pub fn tilt_deg(&self) -> [f64; 2] {
        self.vehicle.borrow().tilt_rad().map(f64::to_degrees)
    }
}
