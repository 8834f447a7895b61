//! What can go wrong between a simulation and a board, in words that say what to look at.

/// Why a flight with a board in the loop did not come about or did not end.
#[derive(Debug, thiserror::Error)]
pub enum HitlError {
    /// The stream itself.
    #[error("the port: {0}")]
    Port(#[from] std::io::Error),
    /// Not a byte.
    #[error(
        "no answer from the board within {waited_s} s: is it powered, started (the bootloader takes 5 s on USB), and \
         TELEM1's TX wired to this port's RX and RX to TX?"
    )]
    Silent {
        /// How long was waited, s.
        waited_s: f64,
    },
    /// Bytes, but no message.
    #[error(
        "{bytes} bytes came, but no MAVLink message among them: another baud rate? A board in HITL mode speaks at \
         921600, else at 115200"
    )]
    Garbage {
        /// Bytes that came.
        bytes: u64,
    },
    /// A vehicle, but not one that takes a simulation.
    #[error("the board answers but is not in HITL mode: set its parameter for it and restart it")]
    NotInHil,
    /// Heartbeats, but no answers.
    #[error("the board does not answer HIL_SENSOR, sent {attempts} times: are bytes lost on the way to it?")]
    NoAnswer {
        /// Messages that were sent in vain.
        attempts: u32,
    },
    /// The supervisor said no.
    #[error("the board does not arm: {words}")]
    NotArmed {
        /// The board's own words.
        words: String,
    },
    /// The sequence was not begun.
    #[error("the board is armed but does not start the test sequence: {words}")]
    NotStarted {
        /// The board's own words.
        words: String,
    },
    /// In flight it fell silent.
    #[error("the board fell silent {flown_s:.3} s into the flight; last words: {words}")]
    Lost {
        /// Flown until then, s.
        flown_s: f64,
        /// The board's last words.
        words: String,
    },
    /// In flight the motors were stopped.
    #[error("the board disarmed {flown_s:.3} s into the flight: {words}")]
    Disarmed {
        /// Flown until then, s.
        flown_s: f64,
        /// The board's own words.
        words: String,
    },
}
