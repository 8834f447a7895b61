//! The flight log on the SD card: from the loop's recorder to sectors, in the idle loop.
//!
//! Whatever the card does, nothing waits for it: the idle loop is interrupted by everything else, and what the recorder
//! has no room for is left out and counted. Without a card nothing is recorded.

use core::sync::atomic::{AtomicBool, Ordering};

use rtic::Mutex;
use shared_control::link::VehicleStatus;
use shared_control::log_card::{BLOCK_BYTES, CardError, CardLog, LogShelf, WINDOW_BYTES};
use shared_control::onboard_log::{self, Recorder, Stage};
use shared_control::params::Params;
use shared_control::supervisor::Arming;

use super::clock::TimeBase;
use super::counters;
use super::queue::{Producer, Queue};
use super::sd_card::SdCard;

/// Room between the loop and the card: 0.65 s of the most that the loop writes, 95 kB/s, where a card may pause for
/// 0.5 s.
const RING_BYTES: usize = 64 << 10;
/// The loop's end of the log.
pub type FlightRecorder = Recorder<RING_BYTES>;

/// Bytes that the recorder hands over at once: as long the loop has to wait for the recorder, some 5 us.
const PIECE_BYTES: usize = 128;
/// Fewer bytes than that wait for more.
const WORTH_BYTES: usize = 512;
/// Pieces that make up a block, and one more.
const PIECES_MAX: usize = BLOCK_BYTES / PIECE_BYTES + 1;
/// So long after a card that was not there or not good the slot is looked at again, us; only on the ground.
const LOOK_PERIOD_US: u64 = 2_000_000;

/// A log is wanted: there is a card for it.
static WANTED: AtomicBool = AtomicBool::new(false);

/// Is there a card for a log?
pub fn is_wanted() -> bool {
    WANTED.load(Ordering::Relaxed)
}

/// Nothing is recorded, nor may a motor turn.
pub fn is_idle(
    recorder: &mut impl Mutex<T = &'static mut FlightRecorder>,
    status: &mut impl Mutex<T = VehicleStatus>,
) -> bool {
    let is_disarmed = status.lock(|status| matches!(status.arming, Arming::Disarmed(_)));
    is_disarmed && recorder.lock(|recorder| recorder.stage() == Stage::Idle)
}

/// What the ground is told of the card.
#[derive(Clone, Copy)]
pub enum News {
    /// A log began, with this number.
    Begun(u32),
    /// A log ended in which so many steps are left out.
    LeftOut(u32),
    /// There is no log, or it has ended.
    Failed(CardError),
}

/// From the log to housekeeping.
pub type NewsQueue = Queue<News, 8>;

/// The card and what is written to it.
pub struct FlightLog {
    card: SdCard,
    log: Option<CardLog>,
    params: Params,
    news: Producer<'static, News>,
    clock: TimeBase,
    /// The slot is looked at then.
    look_us: u64,
    /// What was told last of a card that cannot be used, so that it is told once.
    told: Option<CardError>,
    /// Steps that earlier logs left out.
    left_out_before: u32,
}

impl FlightLog {
    /// Before the first look at the slot.
    pub fn new(card: SdCard, params: &Params, news: Producer<'static, News>) -> Self {
        let clock = TimeBase::START;
        Self { card, log: None, params: *params, news, clock, look_us: 0, told: None, left_out_before: 0 }
    }

    /// What a log's head says.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// What the next log's head is to say; none is under way.
    pub fn use_params(&mut self, params: &Params) {
        self.params = *params;
    }

    /// Does what there is to do, a block at most. Recorder and shelf are held as long as it takes to copy a piece. Not
    /// inlined: while parameters are made its buffers need not be on the stack.
    #[inline(never)]
    pub fn update(
        &mut self,
        recorder: &mut impl Mutex<T = &'static mut FlightRecorder>,
        shelf: &mut impl Mutex<T = LogShelf>,
        status: &mut impl Mutex<T = VehicleStatus>,
    ) {
        let now_us = self.clock.now_us();
        if self.log.is_none() {
            if now_us >= self.look_us && !status.lock(|status| status.arming.is_armed()) {
                self.look(now_us, shelf);
                recorder.lock(|recorder| recorder.close());
            }
            return;
        }
        let (stage, waiting, left_out) =
            recorder.lock(|recorder| (recorder.stage(), recorder.waiting(), recorder.steps_dropped));
        counters::LOG_STEPS_LEFT_OUT.set(left_out);
        let done = match stage {
            Stage::Idle => self.fetch(shelf),
            Stage::Running { start_us } => self.go_on(start_us, waiting, now_us, recorder),
            Stage::Ended if waiting > 0 => self.go_on(now_us, waiting.max(WORTH_BYTES), now_us, recorder),
            Stage::Ended => self.end(left_out, now_us, recorder).and_then(|()| self.list(shelf)),
        };
        if let Err(error) = done {
            self.give_up(error, now_us);
            shelf.lock(|shelf| *shelf = LogShelf::EMPTY);
        }
    }

    /// Reads which logs there are.
    fn list(&mut self, shelf: &mut impl Mutex<T = LogShelf>) -> Result<(), CardError> {
        let Some(log) = &mut self.log else { return Ok(()) };
        let listed = log.list(&mut self.card)?;
        shelf.lock(|shelf| *shelf = listed);
        Ok(())
    }

    /// Reads what somebody waits for.
    fn fetch(&mut self, shelf: &mut impl Mutex<T = LogShelf>) -> Result<(), CardError> {
        let Some(log) = &mut self.log else { return Ok(()) };
        let Some(wanted) = shelf.lock(|shelf| shelf.wanted()) else { return Ok(()) };
        let mut window = [0; WINDOW_BYTES];
        let count = log.fetch(&mut self.card, &wanted, &mut window)?;
        shelf.lock(|shelf| shelf.bring(wanted, window.get(..count).unwrap_or_default()));
        Ok(())
    }

    /// Looks what is in the slot. By itself, so that its buffers lie on the stack only on the ground.
    #[inline(never)]
    fn look(&mut self, now_us: u64, shelf: &mut impl Mutex<T = LogShelf>) {
        let mounted = self.card.identify().and_then(|()| CardLog::mount(&mut self.card));
        let listed = mounted.and_then(|log| {
            self.log = Some(log);
            self.list(shelf)
        });
        match listed {
            Ok(()) => {
                self.told = None;
                WANTED.store(true, Ordering::Relaxed);
            }
            Err(error) => {
                self.log = None;
                if self.told != Some(error) {
                    self.tell(News::Failed(error));
                }
                (self.told, self.look_us) = (Some(error), now_us.saturating_add(LOOK_PERIOD_US));
            }
        }
    }

    fn go_on(
        &mut self,
        start_us: u64,
        waiting: usize,
        now_us: u64,
        recorder: &mut impl Mutex<T = &'static mut FlightRecorder>,
    ) -> Result<(), CardError> {
        let Some(log) = &mut self.log else { return Ok(()) };
        if !log.is_open() {
            let name = log.begin(&mut self.card, now_us)?;
            let information = [("sys_name", "Pixhawk 1")];
            let card = &mut self.card;
            onboard_log::head(start_us, FlightRecorder::TOPICS, &information, Some(&self.params), &mut |bytes| {
                log.put(card, bytes);
            });
            self.tell(News::Begun(name.0));
            return Ok(());
        }
        let is_due = log.is_due(now_us);
        let mut left = if is_due || waiting >= WORTH_BYTES { waiting.min(log.room()) } else { 0 };
        let mut piece = [0; PIECE_BYTES];
        for _ in 0..PIECES_MAX {
            let wanted = piece.get_mut(..left.min(PIECE_BYTES)).unwrap_or_default();
            let count = if left > 0 { recorder.lock(|recorder| recorder.take(wanted)) } else { 0 };
            if count == 0 {
                break;
            }
            left = left.saturating_sub(count);
            log.append(&mut self.card, piece.get(..count).unwrap_or_default())?;
        }
        if is_due { log.flush(&mut self.card, now_us) } else { Ok(()) }
    }

    fn end(
        &mut self,
        left_out: u32,
        now_us: u64,
        recorder: &mut impl Mutex<T = &'static mut FlightRecorder>,
    ) -> Result<(), CardError> {
        let Some(log) = &mut self.log else { return Ok(()) };
        let ended = log.end(&mut self.card, now_us);
        // also where that failed: the next arming begins another
        recorder.lock(|recorder| recorder.close());
        let new = left_out.wrapping_sub(self.left_out_before);
        self.left_out_before = left_out;
        if new > 0 {
            self.tell(News::LeftOut(new));
        }
        ended
    }

    /// No log any more, until the slot is looked at again.
    fn give_up(&mut self, error: CardError, now_us: u64) {
        WANTED.store(false, Ordering::Relaxed);
        (self.log, self.told) = (None, Some(error));
        self.look_us = now_us.saturating_add(LOOK_PERIOD_US);
        self.tell(News::Failed(error));
    }

    fn tell(&mut self, news: News) {
        if self.news.enqueue(news).is_err() {
            counters::ANSWERS_DROPPED.add();
        }
    }
}
