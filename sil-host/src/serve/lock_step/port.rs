//! The connection to a simulator, which waits for it: made, made again once it is lost, and what goes over it.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use super::LockStep;
use crate::serve::OutOfOrder;

/// Where PX4's convention has the simulator wait.
pub const PORT: u16 = 4560;
/// From one attempt to the next.
const ATTEMPT_EVERY: Duration = Duration::from_millis(200);
/// Longest that an attempt holds everything up.
const ATTEMPT: Duration = Duration::from_millis(100);
/// Longest that bytes are waited for; they wake it.
const LOOK: Duration = Duration::from_millis(1);
/// A simulator that sends nothing for so long has stopped, or never began.
const SILENCE: Duration = Duration::from_secs(2);

/// A connection, or the attempt to have one.
pub struct SimulatorPort {
    address: SocketAddr,
    stream: Option<TcpStream>,
    attempted: Option<Instant>,
    heard: Instant,
    is_silent: bool,
    news: Vec<String>,
}

impl SimulatorPort {
    /// For a simulator at this address; nothing is opened yet.
    pub fn new(address: SocketAddr) -> Self {
        Self { address, stream: None, attempted: None, heard: Instant::now(), is_silent: false, news: Vec::new() }
    }

    /// What happened, in words, since the last time.
    pub fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }

    /// Lets the board hear what has come, and sends its answers; waits a moment for it. False without a simulator.
    ///
    /// # Errors
    /// As [`LockStep::hear`].
    pub fn exchange(&mut self, lock_step: &mut LockStep) -> Result<bool, OutOfOrder> {
        let now = Instant::now();
        if self.stream.is_none() && !self.attempt(lock_step, now) {
            return Ok(false);
        }
        let Some(stream) = &mut self.stream else { return Ok(false) };
        let mut buffer = [0; 4096];
        let lost = match stream.read(&mut buffer) {
            Ok(0) => Some("has left".to_owned()),
            Ok(length) => {
                (self.heard, self.is_silent) = (now, false);
                for byte in &buffer[..length] {
                    lock_step.hear(*byte)?;
                }
                stream.write_all(&lock_step.take_sent()).err().map(|error| format!("is lost: {error}"))
            }
            Err(error) if is_nothing_yet(&error) => None,
            Err(error) => Some(format!("is lost: {error}")),
        };
        if let Some(words) = lost {
            self.news.push(format!("simulator at {} {words}: the vehicle has no IMU any more", self.address));
            self.stream = None;
            lock_step.disconnected();
        } else if !self.is_silent && now.duration_since(self.heard) > SILENCE {
            self.is_silent = true;
            self.news.push(format!("simulator at {} sends nothing: its time stands still", self.address));
        }
        Ok(self.stream.is_some())
    }

    fn attempt(&mut self, lock_step: &mut LockStep, now: Instant) -> bool {
        if self.attempted.is_some_and(|attempted| now.duration_since(attempted) < ATTEMPT_EVERY) {
            return false;
        }
        if self.attempted.is_none() {
            self.news.push(format!("waits for a simulator at {}", self.address));
        }
        self.attempted = Some(now);
        let opened = TcpStream::connect_timeout(&self.address, ATTEMPT).and_then(|stream| {
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(LOOK))?;
            Ok(stream)
        });
        let Ok(mut stream) = opened else { return false };
        lock_step.connected();
        if stream.write_all(&lock_step.take_sent()).is_err() {
            return false;
        }
        self.news.push(format!("simulator at {} is here", self.address));
        (self.stream, self.heard, self.is_silent) = (Some(stream), now, false);
        true
    }
}

fn is_nothing_yet(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}
