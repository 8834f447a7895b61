//! Endpoints as the device's registers show them. RM0090 section 34.16.4, from OTG_FS_DIEPCTL0 on.

use std::collections::VecDeque;

use crate::peripherals::Unmodelled;

pub(super) const USBAEP: u32 = 1 << 15;
const TOGGLE: u32 = 1 << 16;
pub(super) const NAKSTS: u32 = 1 << 17;
const EPTYP: u32 = 0b11 << 18;
pub(super) const STALL: u32 = 1 << 21;
const TXFNUM: u32 = 0xf << 22;
const CNAK: u32 = 1 << 26;
const SNAK: u32 = 1 << 27;
const SD0PID: u32 = 1 << 28;
const SODDFRM: u32 = 1 << 29;
const EPDIS: u32 = 1 << 30;
pub(super) const EPENA: u32 = 1 << 31;

// DIEPINTx and DOEPINTx
pub(super) const XFRC: u32 = 1;
const EPDISD: u32 = 1 << 1;
pub(super) const STUP: u32 = 1 << 3;
const ITTXFE: u32 = 1 << 4;
const INEPNE: u32 = 1 << 6;
pub(super) const TXFE: u32 = 1 << 7;
/// Flags that writing ones clears.
const CLEARED_BY_ONES: u32 = 0x7b;

const PACKETS: u32 = 0x3ff << 19;
const PACKET: u32 = 1 << 19;
const BYTES: u32 = 0x7_ffff;
/// Endpoint 0 has fewer bits of both: 127 bytes; 3 packets in, 1 out.
const BYTES_0: u32 = 0x7f;
const IN_SIZE_0: u32 = 0b11 << 19 | BYTES_0;
const OUT_SIZE_0: u32 = 0b11 << 29 | 1 << 19 | BYTES_0;

const BUSY: Unmodelled = Unmodelled("transfer size written while the endpoint is enabled");
const TYPE: Unmodelled = Unmodelled("isochronous endpoint");

/// The device's answer to a token that is addressed to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// None: the host times out.
    Silence,
    Nak,
    Stall,
    /// A packet was taken.
    Ack,
    /// A packet, with its toggle.
    Data(Vec<u8>, bool),
}

/// Control, size and flags: what both directions have.
#[derive(Clone, Debug)]
pub(super) struct Endpoint {
    number: usize,
    pub(super) control: u32,
    pub(super) size: u32,
    pub(super) flags: u32,
}

impl Endpoint {
    pub(super) fn new(number: usize) -> Self {
        Self { number, control: if number == 0 { USBAEP } else { 0 }, size: 0, flags: 0 }
    }

    /// Bytes of a packet at most.
    pub(super) fn packet_bytes(&self) -> usize {
        match (self.number, self.control & 3) {
            (0, code) => 64 >> code,
            _ => (self.control & 0x7ff) as usize,
        }
    }

    pub(super) fn is(&self, bits: u32) -> bool {
        self.control & bits == bits
    }

    pub(super) fn packets_left(&self) -> u32 {
        (self.size & PACKETS) / PACKET
    }

    fn count_packet(&mut self) {
        self.size -= PACKET;
    }

    /// The bus was reset: only endpoint 0 stays active (USBAEP).
    pub(super) fn bus_reset(&mut self) {
        if self.number > 0 {
            self.control &= !USBAEP;
        }
    }

    /// DxEPCTLx; whether the endpoint has become enabled by it. `may_disable`: is what must come before done?
    pub(super) fn write_control(&mut self, value: u32, may_disable: bool) -> Result<bool, Unmodelled> {
        if value & SODDFRM != 0 || self.number > 0 && value & USBAEP != 0 && value & EPTYP == 1 << 18 {
            return Err(TYPE);
        }
        // EP0 is always active, and its type is control
        let settings = if self.number == 0 { 0b11 | TXFNUM } else { 0x7ff | USBAEP | EPTYP | TXFNUM };
        self.control = self.control & !settings | value & settings;
        // of a control endpoint only a SETUP clears STALL
        let stall = value & STALL | if self.number == 0 { self.control & STALL } else { 0 };
        self.control = self.control & !STALL | stall;
        if value & SD0PID != 0 {
            self.control &= !TOGGLE;
        }
        match value & (CNAK | SNAK) {
            CNAK => self.control &= !NAKSTS,
            SNAK => {
                self.control |= NAKSTS;
                self.flags |= INEPNE;
            }
            0 => {}
            _ => return Err(Unmodelled("NAK set and cleared at once")),
        }
        if value & EPDIS != 0 {
            if !may_disable || !self.is(EPENA) {
                return Err(Unmodelled("endpoint disabled that is not enabled, or not set to NAK before"));
            }
            self.control &= !EPENA;
            self.flags |= EPDISD;
            return Ok(false);
        }
        let enables = value & EPENA != 0 && !self.is(EPENA);
        if enables {
            if self.number > 0 && !self.is(USBAEP) {
                return Err(Unmodelled("endpoint enabled that is not active"));
            }
            self.control |= EPENA;
        }
        Ok(enables)
    }

    pub(super) fn clear_flags(&mut self, ones: u32) {
        self.flags &= !(ones & CLEARED_BY_ONES);
    }
}

/// Towards the host, with its FIFO.
#[derive(Clone, Debug)]
pub(super) struct InEndpoint {
    pub(super) common: Endpoint,
    fifo: VecDeque<u32>,
    /// Of the transfer, what has not been sent, bytes.
    unsent: usize,
    /// The same of what was not written into the FIFO, words.
    unwritten: usize,
}

impl InEndpoint {
    pub(super) fn new(number: usize) -> Self {
        Self { common: Endpoint::new(number), fifo: VecDeque::new(), unsent: 0, unwritten: 0 }
    }

    /// DIEPINTx: TXFE is a level.
    pub(super) fn flags(&self) -> u32 {
        self.common.flags | if self.fifo.is_empty() { TXFE } else { 0 }
    }

    /// DTXFSTSx, of a FIFO of so many words.
    pub(super) fn room(&self, depth: u32) -> u32 {
        depth.saturating_sub(self.fifo.len() as u32)
    }

    pub(super) fn write_size(&mut self, value: u32) -> Result<(), Unmodelled> {
        if self.common.is(EPENA) {
            return Err(BUSY);
        }
        let used = if self.common.number == 0 { IN_SIZE_0 } else { 0b11 << 29 | PACKETS | BYTES };
        if value & !used != 0 {
            return Err(Unmodelled("bits of DIEPTSIZ that are reserved"));
        }
        self.common.size = value;
        Ok(())
    }

    pub(super) fn write_control(&mut self, value: u32) -> Result<(), Unmodelled> {
        let may_disable = self.common.is(NAKSTS) || value & SNAK != 0;
        if self.common.write_control(value, may_disable)? {
            let (bytes, packet) = ((self.common.size & BYTES) as usize, self.common.packet_bytes());
            let packets = self.common.packets_left() as usize;
            // the last packet may be short, or empty behind whole ones
            if packets == 0 || packet == 0 || bytes > packets * packet || bytes + packet < packets * packet {
                return Err(Unmodelled("sizes of an IN transfer that do not fit each other"));
            }
            (self.unsent, self.unwritten) = (bytes, bytes.div_ceil(4));
        }
        Ok(())
    }

    /// A word for the FIFO.
    pub(super) fn write(&mut self, word: u32, depth: u32) -> Result<(), Unmodelled> {
        if self.room(depth) == 0 {
            return Err(Unmodelled("more written into a transmit FIFO than there is room for"));
        }
        if !self.common.is(EPENA) || self.unwritten == 0 {
            return Err(Unmodelled("more written into a transmit FIFO than the transfer has"));
        }
        self.unwritten -= 1;
        self.common.size = self.common.size & !BYTES | (self.common.size & BYTES).saturating_sub(4);
        self.fifo.push_back(word);
        Ok(())
    }

    pub(super) fn flush(&mut self) {
        self.fifo.clear();
    }

    /// An IN token. A packet that is not acknowledged stays in the FIFO with its toggle, for the next token (USB 2.0,
    /// section 8.6; packet count and transfer size fall with acknowledged packets alone).
    pub(super) fn token(&mut self, is_acknowledged: bool) -> Answer {
        let common = &mut self.common;
        if !common.is(USBAEP) {
            return Answer::Silence;
        }
        if common.is(STALL) {
            return Answer::Stall;
        }
        let bytes = self.unsent.min(common.packet_bytes());
        if !common.is(EPENA) || common.is(NAKSTS) || self.fifo.len() < bytes.div_ceil(4) {
            if common.is(EPENA) && self.fifo.is_empty() {
                common.flags |= ITTXFE;
            }
            return Answer::Nak;
        }
        let mut data: Vec<u8> = self.fifo.range(..bytes.div_ceil(4)).flat_map(|word| word.to_le_bytes()).collect();
        data.truncate(bytes);
        let toggle = common.is(TOGGLE);
        if !is_acknowledged {
            return Answer::Data(data, toggle);
        }
        self.fifo.drain(..bytes.div_ceil(4));
        self.unsent -= bytes;
        common.count_packet();
        common.control ^= TOGGLE;
        if common.packets_left() == 0 {
            common.control &= !EPENA;
            common.flags |= XFRC;
        }
        Answer::Data(data, toggle)
    }

    /// A SETUP came: NAK until the image has looked at it, and what follows begins with DATA1.
    pub(super) fn setup(&mut self) {
        self.common.control = self.common.control & !STALL | NAKSTS | TOGGLE;
    }
}

/// From the host.
#[derive(Clone, Debug)]
pub(super) struct OutEndpoint {
    pub(super) common: Endpoint,
}

impl OutEndpoint {
    pub(super) fn new(number: usize) -> Self {
        Self { common: Endpoint::new(number) }
    }

    pub(super) fn write_size(&mut self, value: u32) -> Result<(), Unmodelled> {
        // endpoint 0 counts SETUPs, too, and those come whether it is enabled or not
        if self.common.is(EPENA) && self.common.number > 0 {
            return Err(BUSY);
        }
        let used = if self.common.number == 0 { OUT_SIZE_0 } else { 0b11 << 29 | PACKETS | BYTES };
        if value & !used != 0 {
            return Err(Unmodelled("bits of DOEPTSIZ that are reserved"));
        }
        self.common.size = value;
        Ok(())
    }

    pub(super) fn write_control(&mut self, value: u32) -> Result<(), Unmodelled> {
        // endpoint 0 cannot be disabled, and the others only under a global NAK, which has no model
        if self.common.write_control(value, false)? {
            let (bytes, packet) = ((self.common.size & BYTES) as usize, self.common.packet_bytes());
            if self.common.packets_left() == 0 || packet == 0 || !bytes.is_multiple_of(packet) {
                return Err(Unmodelled("size of an OUT transfer that is no multiple of the packet's"));
            }
        }
        Ok(())
    }

    /// A packet that comes with this toggle; `room` is the receive FIFO's. What is to be done with it.
    pub(super) fn token(&mut self, bytes: usize, toggle: bool, room: bool) -> Taken {
        let common = &mut self.common;
        if !common.is(USBAEP) {
            return Taken::No(Answer::Silence);
        }
        if common.is(STALL) {
            return Taken::No(Answer::Stall);
        }
        let ready = common.is(EPENA) && !common.is(NAKSTS) && common.packets_left() > 0;
        if !ready || !room {
            return Taken::No(Answer::Nak);
        }
        // a packet that was sent twice is acknowledged and forgotten
        if common.is(TOGGLE) != toggle {
            return Taken::No(Answer::Ack);
        }
        common.control ^= TOGGLE;
        common.count_packet();
        common.size = common.size & !BYTES | (common.size & BYTES).saturating_sub(bytes as u32);
        let last = common.packets_left() == 0 || bytes < common.packet_bytes();
        if last {
            common.control |= NAKSTS;
        }
        Taken::Packet { last }
    }

    /// A SETUP came.
    pub(super) fn setup(&mut self) {
        let common = &mut self.common;
        common.control = common.control & !STALL | NAKSTS | TOGGLE;
        let count = common.size >> 29 & 3;
        common.size = common.size & !(3 << 29) | count.saturating_sub(1) << 29;
    }

    /// The image has read that a transfer, or the stage of a SETUP, is over.
    pub(super) fn ended(&mut self, flag: u32) {
        self.common.control &= !EPENA;
        self.common.flags |= flag;
    }
}

/// What an endpoint does with a packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Taken {
    No(Answer),
    /// It goes into the FIFO; the last of its transfer or not.
    Packet {
        last: bool,
    },
}
