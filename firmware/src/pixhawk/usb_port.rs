//! The USB connector: a serial port for one computer, looked at a hundred times a second.
//!
//! There is no interrupt. Each look is short and waits for nothing that the computer does: at most 256 bytes come in
//! and 512 go out, which makes 25 and 50 Kbyte a second. What a computer wants of endpoint 0 is answered with the next
//! look, 10 ms later at most; it has to wait for 50 (USB 2.0, section 9.2.6). Without a cable a look is the level of a
//! pin.

use heapless::Vec;
use shared_control::usb::descriptors::{DATA_ENDPOINT, NOTICE_BYTES, NOTICE_ENDPOINT, PACKET_BYTES};
use shared_control::usb::{Control, Reply, Request};
use stm32f4xx_hal::gpio::{Alternate, Input, PA9, PA11, PA12};
use stm32f4xx_hal::rcc::Rcc;

use super::clock;
use super::usb_registers::{
    ADDRESS, AHBIDL, ALL_FIFOS, BULK, CNAK, CSRST, DCFG, DCTL, DEVICE_MODE, DIEPTXF0, DIEPTXF1, DIEPTXF2, EPDIS, EPENA,
    Endpoint, Entry, FULL_SPEED, GAHBCFG, GCCFG, GINTMSK, GINTSTS, GRSTCTL, GRXFSIZ, GUSBCFG, INTERRUPT, PHY_ON,
    RXFFLSH, Registers, SD0PID, SDIS, SNAK, STALL, STUP, TXFFLSH, USBAEP, USBRST, XFRC, chip_id,
};

/// D- and D+.
pub type Lines = (PA11<Alternate<10>>, PA12<Alternate<10>>);
/// High while the connector has 5 V.
pub type Power = PA9<Input>;

/// Bytes that come in at one look at most: whole packets.
const RECEIVE_BYTES: usize = 4 * PACKET_BYTES;
/// Bytes that leave at once at most: the data endpoint's FIFO.
pub const SEND_BYTES: usize = 8 * PACKET_BYTES;
/// What came in.
pub type Received = Vec<u8, RECEIVE_BYTES>;

/// Of the 320 words of memory: what is received, then what endpoints 0, 1 and 2 send.
const RECEIVE_WORDS: u32 = 128;
const SEND_WORDS: [u32; 3] = [32, (SEND_BYTES / 4) as u32, 16];
const _: () = assert!(RECEIVE_WORDS + SEND_WORDS[0] + SEND_WORDS[1] + SEND_WORDS[2] <= 320);

/// Entries of the receive FIFO that one look takes: more do not fit into it.
const ENTRIES_MAX: usize = RECEIVE_WORDS as usize;
/// Looks at a bit that the core itself turns, within a microsecond; each at least 10 cycles of 6 ns long.
const BIT_LOOKS: u32 = 1000;

const CONTROL_IN: Endpoint = Endpoint::input(0);
const CONTROL_OUT: Endpoint = Endpoint::output(0);
const DATA_IN: Endpoint = Endpoint::input(DATA_ENDPOINT as usize);
const DATA_OUT: Endpoint = Endpoint::output(DATA_ENDPOINT as usize);
const NOTICE_IN: Endpoint = Endpoint::input(NOTICE_ENDPOINT as usize);
/// Room for three SETUPs in a row and one packet.
const CONTROL_SIZE: u32 = 3 << 29 | 1 << 19 | PACKET_BYTES as u32;

/// The port.
pub struct UsbPort {
    registers: Registers,
    power: Power,
    _lines: Lines,
    control: Control,
    is_attached: bool,
    setup: [u8; 8],
    /// The data stage of a request is awaited.
    awaits_data: bool,
    control_data: Vec<u8, PACKET_BYTES>,
}

impl UsbPort {
    /// Nothing is plugged in yet.
    pub fn new(registers: Registers, (power, lines): (Power, Lines), rcc: &mut Rcc) -> Self {
        rcc.ahb2enr().modify(|_, w| w.otgfsen().set_bit());
        let control = Control::new(chip_id());
        let (setup, control_data) = ([0; 8], Vec::new());
        Self { registers, power, _lines: lines, control, is_attached: false, setup, awaits_data: false, control_data }
    }

    /// Has a program on the computer the port open?
    pub fn is_open(&self) -> bool {
        self.is_attached && self.control.is_open()
    }

    /// Has the computer fetched what was sent last?
    pub fn is_free(&self) -> bool {
        self.is_open() && self.registers.control(DATA_IN) & EPENA == 0
    }

    /// Does all that has become due, and gives what came in.
    pub fn look(&mut self) -> Received {
        let mut received = Received::new();
        let powered = self.power.is_high();
        if powered != self.is_attached {
            self.control.reset();
            self.is_attached = powered && self.attach();
            if !self.is_attached {
                self.detach();
            }
        }
        if !self.is_attached {
            return received;
        }
        if self.registers.read(GINTSTS) & USBRST != 0 {
            self.registers.write(GINTSTS, USBRST);
            self.bus_reset();
        }
        self.take_entries(&mut received);
        self.serve_control();
        if self.control.is_configured() && self.registers.control(DATA_OUT) & EPENA == 0 {
            let packets = (RECEIVE_BYTES / PACKET_BYTES) as u32;
            self.registers.set_size(DATA_OUT, packets << 19 | RECEIVE_BYTES as u32);
            self.registers.order(DATA_OUT, EPENA | CNAK);
        }
        received
    }

    /// Sends, if all that was sent before is gone. False if not: then it is lost.
    pub fn send(&mut self, bytes: &[u8]) -> bool {
        let free = self.is_free() && bytes.len() <= SEND_BYTES;
        if free {
            // the last packet is short or empty, which tells the computer that there is nothing more to wait for
            let packets = (bytes.len() / PACKET_BYTES + 1) as u32;
            self.registers.set_size(DATA_IN, packets << 19 | bytes.len() as u32);
            self.registers.order(DATA_IN, EPENA | CNAK);
            self.registers.fill(DATA_ENDPOINT.into(), bytes);
        }
        free
    }

    /// Waits until the core has turned a bit, not for long. False if it does not.
    fn waits_for(&self, offset: usize, bit: u32, is_set: bool) -> bool {
        (0..BIT_LOOKS).any(|_| (self.registers.read(offset) & bit != 0) == is_set)
    }

    /// From the core's reset to the pull-up. False if the core does not answer; then the next look tries again.
    fn attach(&mut self) -> bool {
        if !self.waits_for(GRSTCTL, AHBIDL, true) {
            return false;
        }
        self.registers.write(GRSTCTL, CSRST);
        if !self.waits_for(GRSTCTL, CSRST, false) {
            return false;
        }
        // three cycles of the PHY's clock
        clock::wait_us(1);
        self.registers.write(DCTL, SDIS);
        self.registers.write(GUSBCFG, DEVICE_MODE);
        self.registers.write(GCCFG, PHY_ON);
        self.registers.write(DCFG, self.registers.read(DCFG) & !ADDRESS | FULL_SPEED);
        self.registers.write(GAHBCFG, 0);
        self.registers.write(GINTMSK, 0);
        self.registers.write(GRXFSIZ, RECEIVE_WORDS);
        let mut start = RECEIVE_WORDS;
        for (register, words) in [DIEPTXF0, DIEPTXF1, DIEPTXF2].into_iter().zip(SEND_WORDS) {
            self.registers.write(register, words << 16 | start);
            start += words;
        }
        self.flush(RXFFLSH);
        self.flush(TXFFLSH | ALL_FIFOS);
        self.registers.write(GINTSTS, USBRST);
        self.registers.set_size(CONTROL_OUT, CONTROL_SIZE);
        self.registers.write(DCTL, 0);
        true
    }

    fn detach(&mut self) {
        self.registers.write(DCTL, SDIS);
        self.registers.write(GCCFG, 0);
    }

    fn flush(&mut self, which: u32) {
        self.registers.write(GRSTCTL, which);
        self.waits_for(GRSTCTL, which & (RXFFLSH | TXFFLSH), false);
    }

    /// Address 0, no configuration, nothing under way (section 34.17.4, initialization on USB reset).
    fn bus_reset(&mut self) {
        self.control.reset();
        self.awaits_data = false;
        self.registers.write(DCFG, self.registers.read(DCFG) & !ADDRESS);
        for endpoint in [CONTROL_OUT, DATA_OUT] {
            self.registers.order(endpoint, SNAK);
            self.registers.take_flags(endpoint);
        }
        for endpoint in [CONTROL_IN, DATA_IN] {
            self.stop(endpoint);
        }
        self.flush(TXFFLSH | ALL_FIFOS);
        self.registers.set_size(CONTROL_OUT, CONTROL_SIZE);
    }

    /// Ends what an endpoint sends. What lies in its FIFO has to be flushed.
    fn stop(&mut self, endpoint: Endpoint) {
        if self.registers.control(endpoint) & EPENA != 0 {
            self.registers.order(endpoint, SNAK);
            self.registers.order(endpoint, SNAK | EPDIS);
            let _ = (0..BIT_LOOKS).any(|_| self.registers.control(endpoint) & EPENA == 0);
        }
        self.registers.take_flags(endpoint);
    }

    fn take_entries(&mut self, received: &mut Received) {
        for _ in 0..ENTRIES_MAX {
            let Some(entry) = self.registers.next_entry() else { return };
            let (endpoint, mut left) = match entry {
                Entry::Setup => {
                    let (first, second) = (self.registers.receive_word(), self.registers.receive_word());
                    let ([a, b, c, d], [e, f, g, h]) = (first.to_le_bytes(), second.to_le_bytes());
                    self.setup = [a, b, c, d, e, f, g, h];
                    continue;
                }
                Entry::Data(endpoint, bytes) => (endpoint, bytes),
                Entry::End => continue,
            };
            // a packet's words, 512 at most by the width of its length
            while left > 0 {
                let word = self.registers.receive_word().to_le_bytes();
                for byte in word.into_iter().take(left) {
                    // there is room for what the endpoint was enabled for
                    let _ = if endpoint == 0 { self.control_data.push(byte) } else { received.push(byte) };
                }
                left = left.saturating_sub(word.len());
            }
        }
    }

    fn serve_control(&mut self) {
        let flags = self.registers.take_flags(CONTROL_OUT);
        if flags & STUP != 0 {
            self.registers.set_size(CONTROL_OUT, CONTROL_SIZE);
            self.awaits_data = false;
            let request = Request::new(self.setup);
            let reply = self.control.take(&request);
            self.answer(&request, reply);
        } else if flags & XFRC != 0 && core::mem::take(&mut self.awaits_data) {
            self.control.data(&self.control_data);
            self.send_control(&[], 0);
        }
    }

    fn answer(&mut self, request: &Request, reply: Reply) {
        match reply {
            Reply::Send(bytes) => {
                self.send_control(&bytes, request.length.into());
                self.registers.order(CONTROL_OUT, EPENA | CNAK);
                return;
            }
            Reply::Receive => {
                self.awaits_data = true;
                self.control_data.clear();
                self.registers.order(CONTROL_OUT, EPENA | CNAK);
                return;
            }
            Reply::Refuse => {
                self.registers.order(CONTROL_IN, STALL);
                self.registers.order(CONTROL_OUT, STALL);
                return;
            }
            Reply::Done => {}
            // the core keeps the old one until the host has been told
            Reply::Address(address) => {
                self.registers.write(DCFG, self.registers.read(DCFG) & !ADDRESS | u32::from(address) << 4);
            }
            Reply::Restart => self.restart_endpoints(),
            Reply::Halt(endpoint, halted) => self.halt(endpoint, halted),
        }
        self.send_control(&[], 0);
    }

    /// An answer of endpoint 0, of which the host takes at most so much.
    fn send_control(&mut self, bytes: &[u8], most: usize) {
        if self.registers.control(CONTROL_IN) & EPENA != 0 {
            self.stop(CONTROL_IN);
            self.flush(TXFFLSH);
        }
        // what is shorter than the host takes ends with a packet that is not full
        let ends_full = bytes.len() == most && !bytes.is_empty() && bytes.len().is_multiple_of(PACKET_BYTES);
        let packets = bytes.len() / PACKET_BYTES + usize::from(!ends_full);
        self.registers.set_size(CONTROL_IN, (packets << 19 | bytes.len()) as u32);
        self.registers.order(CONTROL_IN, EPENA | CNAK);
        self.registers.fill(0, bytes);
    }

    /// Another configuration: all toggles begin anew.
    fn restart_endpoints(&mut self) {
        self.stop(DATA_IN);
        self.flush(TXFFLSH | u32::from(DATA_ENDPOINT) << 6);
        let fifo = |number: u8| u32::from(number) << 22;
        if self.control.is_configured() {
            let data = USBAEP | BULK | PACKET_BYTES as u32;
            self.registers.set(DATA_IN, data | fifo(DATA_ENDPOINT) | SD0PID | SNAK);
            self.registers.set(DATA_OUT, data | SD0PID | CNAK);
            let notice = USBAEP | INTERRUPT | NOTICE_BYTES as u32;
            self.registers.set(NOTICE_IN, notice | fifo(NOTICE_ENDPOINT) | SD0PID | SNAK);
        } else {
            self.registers.set(DATA_IN, fifo(DATA_ENDPOINT) | SNAK);
            self.registers.set(DATA_OUT, SNAK);
            self.registers.set(NOTICE_IN, fifo(NOTICE_ENDPOINT) | SNAK);
        }
    }

    fn halt(&mut self, endpoint: u8, halted: bool) {
        const DATA_TO_HOST: u8 = DATA_ENDPOINT | 0x80;
        let endpoint = match endpoint {
            DATA_TO_HOST => DATA_IN,
            DATA_ENDPOINT => DATA_OUT,
            _ => NOTICE_IN,
        };
        if halted {
            self.registers.order(endpoint, STALL);
        } else {
            self.registers.set(endpoint, self.registers.control(endpoint) & !(STALL | EPENA | EPDIS) | SD0PID);
        }
    }
}
