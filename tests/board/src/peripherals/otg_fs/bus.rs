//! What happens at the connector: voltage, resets, frames, tokens.

use super::endpoints::{EPENA, NAKSTS, Taken};
use super::fifo::Status;
use super::{
    ADDRESS, Answer, ENDPOINTS, ENUMDNE, ESUSP, NOVBUSSENS, OtgFs, PHY_HZ, PWRDWN, SDIS, SEDET, SOF, SRQINT,
    TURNAROUND, USBRST, USBSUSP, VBUSBSEN, WKUPINT,
};
use crate::peripherals::Unmodelled;
use crate::time::TICKS_PER_S;

impl OtgFs {
    /// The voltage at the sensing pin, and whether both data lines lead to the PHY.
    pub(crate) fn set_connector(&mut self, vbus: bool, wired: bool) {
        if (self.vbus, self.wired) != (vbus, wired) {
            (self.vbus, self.wired) = (vbus, wired);
            self.refresh_session();
        }
    }

    pub(super) fn session_is_valid(&self) -> bool {
        let sensed = self.core_config & VBUSBSEN != 0 && self.vbus;
        self.core_config & PWRDWN != 0 && (sensed || self.core_config & NOVBUSSENS != 0)
    }

    /// A session that begins or ends where the voltage is looked at (section 34.16.2, SRQINT and SEDET).
    pub(super) fn refresh_session(&mut self) {
        if self.core_config & (VBUSBSEN | NOVBUSSENS | PWRDWN) != VBUSBSEN | PWRDWN {
            return;
        }
        if self.vbus {
            self.interrupts |= SRQINT;
        } else {
            self.otg_interrupts |= SEDET;
        }
    }

    /// Is D+ pulled up?
    pub(crate) fn is_attached(&self) -> bool {
        let clocked = self.phy_cycle.is_some_and(|cycle| TICKS_PER_S / cycle == PHY_HZ);
        clocked && self.wired && self.session_is_valid() && self.device_control & SDIS == 0 && self.reset_end.is_none()
    }

    /// The host resets the bus.
    pub(crate) fn bus_reset_begins(&mut self) {
        self.interrupts |= USBRST;
        self.suspended = false;
        self.setup_open = false;
        for endpoint in self.ins.iter_mut().map(|endpoint| &mut endpoint.common) {
            endpoint.bus_reset();
        }
        for endpoint in self.outs.iter_mut().map(|endpoint| &mut endpoint.common) {
            endpoint.bus_reset();
        }
    }

    /// It ends: the speed is known.
    ///
    /// # Errors
    /// If the turnaround time does not fit the AHB's clock (table 203).
    pub(crate) fn bus_reset_ends(&mut self) -> Result<(), Unmodelled> {
        self.interrupts |= ENUMDNE;
        // the address is what the image says, which has to make it 0
        self.address = (self.device_config >> 4) as u8 & 0x7f;
        let turnaround = self.usb_config >> 10 & 0xf;
        if turnaround == TURNAROUND { Ok(()) } else { Err(Unmodelled("turnaround time for another clock of the AHB")) }
    }

    /// A frame begins.
    pub(crate) fn start_of_frame(&mut self, number: u32) {
        self.frame = number & 0x7ff;
        self.interrupts |= SOF;
    }

    /// Nothing has happened on the bus for 3 ms.
    pub(crate) fn suspend(&mut self) {
        if !self.suspended {
            self.suspended = true;
            self.interrupts |= ESUSP | USBSUSP;
        }
    }

    /// The bus lives again.
    pub(crate) fn resume(&mut self) {
        if std::mem::take(&mut self.suspended) {
            self.interrupts |= WKUPINT;
        }
    }

    /// DCFG has another address: in force behind the status stage of the request that sets it.
    pub(super) fn take_address(&mut self) {
        let wanted = ((self.device_config & ADDRESS) >> 4) as u8;
        let status_open = self.setup_open || !self.ins[0].common.is(EPENA) && self.ins[0].common.is(NAKSTS);
        if wanted == 0 || !status_open {
            self.address = wanted;
        }
    }

    fn answers(&self, address: u8, endpoint: usize) -> bool {
        self.is_attached() && address == self.address && endpoint < ENDPOINTS
    }

    /// A SETUP with its eight bytes: always taken where there is room.
    pub(crate) fn setup(&mut self, address: u8, request: &[u8; 8]) -> Answer {
        if !self.answers(address, 0) || !self.receive.has_room(request.len(), self.receive_depth) {
            return Answer::Silence;
        }
        self.receive.push(Status::SetupData, 0, request, false);
        self.setup_open = true;
        self.ins[0].setup();
        self.outs[0].setup();
        Answer::Ack
    }

    /// The first token behind a SETUP ends its stage.
    fn end_setup(&mut self, endpoint: usize) {
        if endpoint == 0 && self.setup_open && self.receive.has_room(0, self.receive_depth) {
            self.setup_open = false;
            self.receive.push(Status::SetupComplete, 0, &[], false);
        }
    }

    /// An IN token.
    pub(crate) fn input(&mut self, address: u8, endpoint: usize) -> Answer {
        if !self.answers(address, endpoint) {
            return Answer::Silence;
        }
        self.end_setup(endpoint);
        let answer = self.ins[endpoint].token(true);
        if let (0, Answer::Data(bytes, _)) = (endpoint, &answer)
            && bytes.is_empty()
        {
            self.address = ((self.device_config & ADDRESS) >> 4) as u8;
        }
        answer
    }

    /// An IN token behind which no acknowledgement comes: what the device sent was damaged on its way, or the
    /// acknowledgement was. Not of endpoint 0.
    pub(crate) fn input_without_acknowledgement(&mut self, address: u8, endpoint: usize) -> Answer {
        if self.answers(address, endpoint) { self.ins[endpoint].token(false) } else { Answer::Silence }
    }

    /// An OUT token with its packet.
    pub(crate) fn output(&mut self, address: u8, endpoint: usize, bytes: &[u8], toggle: bool) -> Answer {
        if !self.answers(address, endpoint) {
            return Answer::Silence;
        }
        self.end_setup(endpoint);
        // besides the packet its end needs a word
        let room = self.receive.has_room(bytes.len() + 4, self.receive_depth);
        match self.outs[endpoint].token(bytes.len(), toggle, room) {
            Taken::No(answer) => answer,
            Taken::Packet { last } => {
                self.receive.push(Status::OutData, endpoint, bytes, toggle);
                if last {
                    self.receive.push(Status::OutComplete, endpoint, &[], false);
                }
                Answer::Ack
            }
        }
    }
}
