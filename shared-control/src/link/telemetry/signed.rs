//! Signing, where there is time for it: the key, the clock, and words about what is not let in.

use mavlink::dialects::common::MavSeverity;

use super::Telemetry;
use crate::link::signing::{Refused, Signer, Signing, SigningRecord, SigningSetup, Terms};
use crate::link::vehicle_status::VehicleStatus;
use crate::supervisor::Arming;

/// Id of the one link that the vehicle signs for.
const LINK_ID: u8 = 0;

impl Telemetry {
    /// The same with the key and the clock that were kept.
    pub fn with_signing(self, kept: SigningRecord) -> Self {
        Self { signing: Signing::new(kept), ..self }
    }

    /// Does what `SETUP_SIGNING` wants, where somebody beside the vehicle wants it and it is disarmed, and
    /// says what came of it. `store` puts a record into lasting memory; false if it was not kept.
    pub fn set_up_signing(
        &mut self,
        setup: &SigningSetup,
        (status, time_us): (&VehicleStatus, u64),
        store: impl FnOnce(&SigningRecord) -> bool,
    ) {
        let (severity, words) = if !matches!(status.arming, Arming::Disarmed(_)) {
            (MavSeverity::MAV_SEVERITY_WARNING, "signing not changed: armed")
        } else if !setup.is_local {
            (MavSeverity::MAV_SEVERITY_WARNING, "signing not changed: only by cable")
        } else if !self.signing.set_up(setup, time_us, store) {
            (MavSeverity::MAV_SEVERITY_WARNING, "signing not changed: memory failed")
        } else if setup.key.is_some() {
            (MavSeverity::MAV_SEVERITY_NOTICE, "key stored: unsigned frames count no more")
        } else {
            (MavSeverity::MAV_SEVERITY_NOTICE, "signing ended: who reaches the link can fly")
        };
        self.text(severity, words);
    }

    /// To be called about as often as [`Telemetry::poll`], before it. Takes what the guard has seen
    /// ([`Guard::latest_seen`], [`Guard::refused`]) and gives the terms that it goes by from now on.
    ///
    /// [`Guard::latest_seen`]: crate::link::Guard::latest_seen
    /// [`Guard::refused`]: crate::link::Guard::refused
    pub fn update_signing(
        &mut self,
        (seen, refused): (u64, Refused),
        time_us: u64,
        store: impl FnOnce(&SigningRecord) -> bool,
    ) -> Terms {
        self.signing.update(seen, time_us, store);
        let key = self.signing.key();
        self.streams.are_signed = key.is_some();
        let signer = self.writer.signer();
        if signer.map(|signer| signer.key()) != key {
            *signer = key.map(|key| Signer::new(key, LINK_ID));
        }
        if let Some(signer) = signer {
            signer.set_clock(self.signing.now(time_us));
        }
        self.tell_refused(refused, time_us);
        self.signing.terms(time_us)
    }

    fn tell_refused(&mut self, refused: Refused, time_us: u64) {
        let told = self.told_refused;
        if refused == told || !self.refusal.is(time_us) {
            return;
        }
        let words = if refused.wrong != told.wrong {
            "not obeyed: signed with another key"
        } else if refused.untimely != told.untimely {
            "not obeyed: an old signature, or a clock behind"
        } else {
            "not obeyed: not signed"
        };
        self.text(MavSeverity::MAV_SEVERITY_WARNING, words);
        self.told_refused = refused;
        self.refusal.done(time_us);
    }
}
