//! Other parameters come into use: made in the idle loop beside what is in use, taken by the loop between two steps.
//!
//! ```text
//!   housekeeping --Demand: wanted--> idle loop: Setup, MPC in the spare place --Offer--> control_step, if disarmed
//!                <--Demand: made---               spare place <-- the other MPC --'
//! ```
//! The idle loop makes nothing of parameters while a log is written, and writes none while they are offered: a log's
//! head says what the whole of it was flown with. Making may take as long as it likes, everything interrupts it.
//!
//! What a flight has taught goes the same way, in flight ([`super::learner`]).

use core::sync::atomic::{AtomicU8, Ordering};

use rtic::Mutex;
use shared_control::config::Controller;
use shared_control::exchange::{Exchange, Senseless};
use shared_control::learning::adoption::{LearntModel, Refusal};
use shared_control::learning::confidence::Learnt;
use shared_control::learning::lesson::Taught;
use shared_control::link::VehicleStatus;
use shared_control::log_card::LogShelf;
use shared_control::params::Params;
use shared_control::sensing::imu::AxisMap;
use shared_control::setup::{self, Setup};

use super::configuration::BoardMpc;
use super::flight_log::{self, FlightLog, FlightRecorder};
use super::learner::{Learner, Slate};

/// Changes of parameters that arming need not wait for, modulo 256; from housekeeping to the loop.
static SETTLED: AtomicU8 = AtomicU8::new(0);

/// Lets arming wait for no more than these.
pub fn settle(changes: u8) {
    SETTLED.store(changes, Ordering::Relaxed);
}

/// What arming need not wait for.
pub fn settled() -> u8 {
    SETTLED.load(Ordering::Relaxed)
}

/// From housekeeping to the idle loop, and what came of it.
pub struct Demand {
    /// To be brought into use; none where nothing waits.
    pub wanted: Option<Params>,
    /// What has become of it, until housekeeping takes notice.
    pub made: Option<Made>,
    /// What has become of what was learnt, likewise.
    pub learnt: Option<Learning>,
}

impl Demand {
    /// Nothing is wanted.
    pub const NOTHING: Self = Self { wanted: None, made: None, learnt: None };
}

/// What has become of parameters that were wanted.
#[derive(Clone, Copy)]
pub enum Made {
    /// They are in use.
    InUse(Params, Senseless),
    /// They can't be flown.
    NotUsable,
}

/// What has become of what was learnt.
#[derive(Clone, Copy)]
pub enum Learning {
    /// It flies.
    Flown(LearntModel),
    /// Its controller may not fly.
    Refused(Refusal),
}

/// What the loop may take.
#[allow(clippy::large_enum_variant)] // there is one place for either, and no heap
pub enum Next {
    /// Parameters that were set; on the ground.
    Chosen(Exchange),
    /// What a flight taught; in flight too.
    Learnt(Taught),
}

/// From the idle loop to the loop, and back.
pub struct Offer {
    /// Waits for the loop.
    pub next: Option<Next>,
    /// The MPC that goes with it, if one flies; once it is taken the one that flew before.
    pub mpc: Option<&'static mut BoardMpc>,
    /// The loop has taken it.
    pub taken: bool,
}

impl Offer {
    /// Nothing is offered.
    pub const NOTHING: Self = Self { next: None, mpc: None, taken: false };
}

/// The idle loop's part.
pub struct Workshop {
    /// Place for an MPC that does not fly.
    spare: Option<&'static mut BoardMpc>,
    /// How the second gyro was found to sit, where that is not as usual.
    second_gyro: Option<AxisMap>,
    /// What the loop has been offered.
    offered: Option<Offered>,
    learner: Learner,
    log: FlightLog,
}

/// What the loop has been offered, as whoever has to be told of it wants it.
#[derive(Clone, Copy)]
enum Offered {
    Chosen(Params, Senseless),
    Learnt(LearntModel),
}

impl Workshop {
    /// With a place for another MPC.
    pub fn new(spare: &'static mut BoardMpc, second_gyro: Option<AxisMap>, log: FlightLog) -> Self {
        Self { spare: Some(spare), second_gyro, offered: None, learner: Learner::NEW, log }
    }

    /// A turn of the idle loop: what there is to make, and what there is to log.
    pub fn turn(
        &mut self,
        (recorder, shelf, status): (
            &mut impl Mutex<T = &'static mut FlightRecorder>,
            &mut impl Mutex<T = LogShelf>,
            &mut impl Mutex<T = VehicleStatus>,
        ),
        (demand, offer, slate): (&mut impl Mutex<T = Demand>, &mut impl Mutex<T = Offer>, &mut impl Mutex<T = Slate>),
    ) {
        if let Some(params) = self.update(demand, offer, || flight_log::is_idle(recorder, status)) {
            self.log.use_params(&params);
            self.learner = Learner::NEW;
        }
        if !matches!(self.offered, Some(Offered::Chosen(..))) {
            self.log.update(recorder, shelf, status);
        }
        if self.offered.is_none()
            && let Some((lesson, learnt)) = self.learner.look(self.log.params(), slate)
        {
            self.learn((recorder, shelf, status), (demand, offer), (lesson, &learnt));
        }
    }

    /// Makes a controller for what was learnt, where that is another vehicle than the one that is flown, and offers it
    /// once it is proved. The log goes on meanwhile. By itself, as [`Self::make`].
    #[inline(never)]
    fn learn(
        &mut self,
        (recorder, shelf, status): (
            &mut impl Mutex<T = &'static mut FlightRecorder>,
            &mut impl Mutex<T = LogShelf>,
            &mut impl Mutex<T = VehicleStatus>,
        ),
        (demand, offer): (&mut impl Mutex<T = Demand>, &mut impl Mutex<T = Offer>),
        (lesson, learnt): (u32, &Learnt),
    ) {
        let Self { spare, learner, log, offered, .. } = self;
        let params = *log.params();
        let first = setup::flown_vehicle(&params);
        let Some((model, proposal)) = learner.propose((&params, &first), learnt) else { return };
        let Some(mpc) = spare.as_mut() else { return };
        if mpc.prepare_in_place(params.control_horizon.into(), &proposal.mpc()).is_err() {
            return;
        }
        let law = mpc.unconstrained_gain();
        match proposal.prove(law, &first, learnt, || log.update(recorder, shelf, status)) {
            Ok(()) => {
                *offered = Some(Offered::Learnt(model));
                let next = Some(Next::Learnt(proposal.taught(lesson)));
                offer.lock(|offer| (offer.next, offer.mpc, offer.taken) = (next, spare.take(), false));
            }
            Err(refusal) => {
                if learner.is_new(&refusal) {
                    demand.lock(|demand| demand.learnt = Some(Learning::Refused(refusal)));
                }
            }
        }
    }

    /// Does what there is to do. `may_exchange` is true unless something flies or a log is written. Returns what has
    /// come into use.
    fn update(
        &mut self,
        demand: &mut impl Mutex<T = Demand>,
        offer: &mut impl Mutex<T = Offer>,
        mut may_exchange: impl FnMut() -> bool,
    ) -> Option<Params> {
        if let Some(offered) = self.offered {
            let (taken, mpc) = offer.lock(|offer| offer.next.is_none().then(|| (offer.taken, offer.mpc.take())))?;
            self.spare = mpc.or(self.spare.take());
            self.offered = None;
            return match offered {
                Offered::Chosen(params, senseless) if taken => {
                    demand.lock(|demand| (demand.wanted, demand.made) = (None, Some(Made::InUse(params, senseless))));
                    Some(params)
                }
                // it was armed before the loop looked: what is wanted is made again
                Offered::Chosen(..) => None,
                Offered::Learnt(model) => {
                    self.learner.flies(model);
                    demand.lock(|demand| demand.learnt = Some(Learning::Flown(model)));
                    None
                }
            };
        }
        let wanted = demand.lock(|demand| if demand.made.is_none() { demand.wanted } else { None });
        let params = wanted.filter(|_| may_exchange())?;
        match self.make(&params) {
            // something has flown meanwhile: it is made again
            Some(_) if !may_exchange() => {}
            Some(next) => {
                self.offered = Some(Offered::Chosen(params, next.senseless()));
                let mpc = if params.controller == Controller::Mpc { self.spare.take() } else { None };
                offer.lock(|offer| (offer.next, offer.mpc, offer.taken) = (Some(Next::Chosen(next)), mpc, false));
            }
            None => demand.lock(|demand| (demand.wanted, demand.made) = (None, Some(Made::NotUsable))),
        }
        None
    }

    /// By itself, so that the stack that it takes to prepare an MPC is in use only meanwhile.
    #[inline(never)]
    fn make(&mut self, params: &Params) -> Option<Exchange> {
        let mut setup = Setup::new(params).ok()?;
        if let Some(axes) = self.second_gyro {
            setup.config.sensing.imu_second.gyro_axes = axes;
        }
        if params.controller == Controller::Mpc {
            self.spare.as_mut()?.prepare_in_place(params.control_horizon.into(), &setup.mpc).ok()?;
        }
        Some(Exchange::new(params, &setup))
    }
}
