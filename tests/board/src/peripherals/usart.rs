//! Asynchronous serial port, 8 data bits, no parity, one stop bit. RM0090 section 30.6. Bytes take ten bit times.

use std::collections::VecDeque;

use super::line_noise::{LineNoise, Received};
use super::{Peripheral, Unmodelled};
use crate::time::{TICKS_PER_S, Ticks};

const BITS_PER_BYTE: Ticks = 10;

const FE: u32 = 1 << 1;
const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;

const RE: u32 = 1 << 2;
const TE: u32 = 1 << 3;
const UE: u32 = 1 << 13;
/// Parity, nine bits, eight-fold oversampling.
const UNUSED_CONTROL: u32 = 1 << 10 | 1 << 12 | 1 << 15;
const EIE: u32 = 1;
const DMAR: u32 = 1 << 6;
const DMAT: u32 = 1 << 7;
/// IrDA, half duplex, smart card, flow control.
const UNUSED_CONTROL_3: u32 = 0b11_1110 | 0b11 << 8;

/// The port, and on the other end of its line somebody with a baud rate of their own.
#[derive(Clone, Debug)]
pub(crate) struct Usart {
    control: [u32; 3],
    divider: u32,
    status: u32,
    status_seen: u32,
    bus_cycle: Ticks,
    far_byte_ticks: Ticks,
    received: u8,
    incoming: VecDeque<u8>,
    /// What comes when nothing else does: the state of a generator.
    flood: Option<u32>,
    /// Of the line towards the chip.
    noise: Option<LineNoise>,
    incoming_end: Option<Ticks>,
    idle_at: Option<Ticks>,
    holding: Option<u8>,
    shifting: Option<(u8, Ticks)>,
    sent: Vec<u8>,
}

impl Usart {
    pub(crate) fn new(far_baud: u64) -> Self {
        Self {
            control: [0; 3],
            divider: 0,
            status: TXE | TC,
            status_seen: 0,
            bus_cycle: 1,
            far_byte_ticks: TICKS_PER_S * BITS_PER_BYTE / far_baud,
            received: 0,
            incoming: VecDeque::new(),
            flood: None,
            noise: None,
            incoming_end: None,
            idle_at: None,
            holding: None,
            shifting: None,
            sent: Vec::new(),
        }
    }

    /// As after a reset by RCC; the far end does not notice.
    pub(crate) fn reset(&mut self) {
        *self = Self {
            far_byte_ticks: self.far_byte_ticks,
            bus_cycle: self.bus_cycle,
            incoming: std::mem::take(&mut self.incoming),
            incoming_end: self.incoming_end,
            flood: self.flood,
            noise: self.noise.take(),
            sent: std::mem::take(&mut self.sent),
            ..Self::new(1)
        };
    }

    /// The far end's baud rate from now on.
    pub(crate) fn set_far_baud(&mut self, baud: u64) {
        self.far_byte_ticks = TICKS_PER_S * BITS_PER_BYTE / baud;
    }

    /// The far end sends any bytes, without a gap, until told to stop.
    pub(crate) fn flood(&mut self, on: bool, now: Ticks) {
        self.flood = on.then_some(self.flood.unwrap_or(1));
        if on && self.incoming_end.is_none() {
            self.incoming_end = Some(now + self.far_byte_ticks);
            self.idle_at = None;
        }
    }

    /// The line loses and damages bytes from now on.
    pub(crate) fn set_noise(&mut self, noise: Option<LineNoise>) {
        self.noise = noise;
    }

    pub(crate) fn set_bus_cycle(&mut self, cycle: Ticks) {
        self.bus_cycle = cycle;
    }

    /// The far end sends, one byte right after the other.
    pub(crate) fn line_receives(&mut self, bytes: &[u8], now: Ticks) {
        self.incoming.extend(bytes);
        if self.incoming_end.is_none() && !self.incoming.is_empty() {
            self.incoming_end = Some(now + self.far_byte_ticks);
            self.idle_at = None;
        }
    }

    /// What the far end has received since the last call. With another baud rate it sees garbage.
    pub(crate) fn take_sent(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.sent)
    }

    fn byte_ticks(&self) -> Ticks {
        u64::from(self.divider) * self.bus_cycle * BITS_PER_BYTE
    }

    /// Half a bit at the end of a byte is what the receiver can be off.
    fn rates_agree(&self) -> bool {
        self.byte_ticks().abs_diff(self.far_byte_ticks) * 20 < self.far_byte_ticks
    }

    fn is_on(&self, direction: u32) -> bool {
        self.control[0] & (UE | direction) == UE | direction
    }

    fn receive(&mut self, byte: u8) {
        if !self.is_on(RE) {
            return;
        }
        if self.status & RXNE != 0 {
            self.status |= ORE;
            return;
        }
        let good = self.rates_agree();
        self.received = if good { byte } else { !byte };
        self.status |= RXNE | if good { 0 } else { FE };
    }

    fn transmit(&mut self, now: Ticks) {
        if self.shifting.is_some() || !self.is_on(TE) {
            return;
        }
        match self.holding.take() {
            Some(byte) => {
                self.shifting = Some((byte, now + self.byte_ticks()));
                self.status |= TXE;
            }
            None => self.status |= TC,
        }
    }

    fn next_incoming(&mut self, end: Ticks) {
        let flood = &mut self.flood;
        let byte = self.incoming.pop_front().or_else(|| {
            // Numerical Recipes' generator; its high bits are the better ones
            *flood = flood.map(|state| state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
            flood.map(|state| (state >> 24) as u8)
        });
        let received = byte.map(|byte| self.noise.as_mut().map_or(Received::Whole(byte), |noise| noise.pass(byte)));
        if let Some(Received::Whole(byte)) = received {
            self.receive(byte);
        }
        let goes_on = !self.incoming.is_empty() || self.flood.is_some();
        self.incoming_end = goes_on.then_some(end + self.far_byte_ticks);
        // the line counts as idle after the time of one more byte
        self.idle_at = self.incoming_end.is_none().then_some(end + self.far_byte_ticks);
    }

    pub(crate) fn requests_receive_dma(&self) -> bool {
        self.control[2] & DMAR != 0 && self.status & RXNE != 0
    }

    pub(crate) fn requests_transmit_dma(&self) -> bool {
        self.control[2] & DMAT != 0 && self.is_on(TE) && self.status & TXE != 0
    }

    pub(crate) fn interrupt(&self) -> bool {
        // IDLEIE, RXNEIE, TCIE, TXEIE (4 to 7) lie where the flags do; RXNEIE counts for an overrun too
        let by_flag = self.control[0] & self.status & (IDLE | RXNE | TC | TXE);
        let overrun = self.control[0] & RXNE != 0 && self.status & ORE != 0;
        let error = self.control[2] & (EIE | DMAR) == EIE | DMAR && self.status & (FE | ORE) != 0;
        by_flag != 0 || overrun || error
    }
}

impl Peripheral for Usart {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x00 => {
                self.status_seen = self.status;
                Ok(self.status)
            }
            0x04 => {
                // status, then data: clears the errors and IDLE that were seen (section 30.6.1)
                self.status &= !(RXNE | self.status_seen & (FE | ORE | IDLE));
                self.status_seen = 0;
                Ok(u32::from(self.received))
            }
            0x08 => Ok(self.divider),
            0x0c | 0x10 | 0x14 => Ok(self.control[((offset - 0x0c) / 4) as usize]),
            0x18 => Ok(0),
            _ => Err(Unmodelled("USART register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        match offset {
            // TC and RXNE are cleared by writing 0
            0x00 => self.status &= value | !(TC | RXNE),
            0x04 => {
                self.holding = Some(value as u8);
                self.status &= !(TXE | TC);
                self.transmit(now);
            }
            0x08 => self.divider = value & 0xffff,
            0x0c if value & UNUSED_CONTROL != 0 => return Err(Unmodelled("USART other than 8N1, 16 samples a bit")),
            0x10 if value & (0b11 << 12 | 1 << 11 | 1 << 14) != 0 => {
                return Err(Unmodelled("USART stop bits, clock or LIN"));
            }
            0x14 if value & UNUSED_CONTROL_3 != 0 => return Err(Unmodelled("USART flow control or special modes")),
            0x0c | 0x10 | 0x14 => {
                self.control[((offset - 0x0c) / 4) as usize] = value;
                self.transmit(now);
            }
            0x18 if value == 0 => {}
            _ => return Err(Unmodelled("USART register")),
        }
        Ok(())
    }

    fn tick(&mut self, now: Ticks) {
        // one byte at a time each way: DMA has to fetch it before the next is due
        if let Some(end) = self.incoming_end.filter(|end| *end <= now) {
            self.next_incoming(end);
        }
        if self.idle_at.is_some_and(|at| at <= now) {
            self.idle_at = None;
            if self.is_on(RE) {
                self.status |= IDLE;
            }
        }
        if let Some((byte, end)) = self.shifting.filter(|(_, end)| *end <= now) {
            self.sent.push(if self.rates_agree() { byte } else { !byte });
            self.shifting = None;
            self.transmit(end);
        }
    }

    fn next_event(&self) -> Option<Ticks> {
        [self.incoming_end, self.idle_at, self.shifting.map(|(_, end)| end)].into_iter().flatten().min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTE: Ticks = 365 * 8 * 10;

    fn port(far_baud: u64) -> Usart {
        let mut usart = Usart::new(far_baud);
        usart.set_bus_cycle(8);
        usart.write(0x08, 365, 0).unwrap();
        usart.write(0x0c, UE | RE | TE | IDLE, 0).unwrap();
        usart
    }

    #[test]
    fn a_byte_takes_ten_bits_and_the_second_waits_behind_it() {
        let mut usart = port(115_200);
        usart.write(0x04, b'a'.into(), 0).unwrap();
        assert_eq!(usart.read(0, 0).unwrap() & (TXE | TC), TXE);
        usart.write(0x04, b'b'.into(), 0).unwrap();
        assert_eq!(usart.read(0, 0).unwrap() & (TXE | TC), 0);
        assert_eq!(usart.next_event(), Some(BYTE));
        usart.tick(BYTE);
        assert_eq!(usart.read(0, 0).unwrap() & (TXE | TC), TXE);
        usart.tick(2 * BYTE);
        assert_eq!(usart.take_sent(), b"ab");
        assert_eq!(usart.read(0, 0).unwrap() & TC, TC);
    }

    #[test]
    fn the_line_goes_idle_once_after_the_last_byte() {
        let mut usart = port(115_200);
        usart.line_receives(b"xy", 0);
        let mut read = Vec::new();
        let mut idles = 0;
        while let Some(at) = usart.next_event() {
            usart.tick(at);
            let status = usart.read(0, at).unwrap();
            if status & (RXNE | IDLE) != 0 {
                idles += status & IDLE;
                let byte = usart.read(4, at).unwrap() as u8;
                if status & RXNE != 0 {
                    read.push(byte)
                }
            }
        }
        assert_eq!((read.as_slice(), idles), (b"xy".as_slice(), IDLE));
        assert!(!usart.interrupt());
    }

    #[test]
    fn a_byte_that_nobody_reads_is_an_overrun() {
        let mut usart = port(115_200);
        usart.line_receives(b"xy", 0);
        usart.tick(usart.next_event().unwrap());
        usart.tick(usart.next_event().unwrap());
        assert_eq!(usart.read(0, 0).unwrap() & (ORE | RXNE), ORE | RXNE);
        assert_eq!(usart.read(4, 0).unwrap(), u32::from(b'x'));
    }

    #[test]
    fn a_flood_comes_at_the_lines_rate_and_ends_when_told() {
        let mut usart = port(115_200);
        usart.flood(true, 0);
        let mut read = Vec::new();
        for _ in 0..1000 {
            let at = usart.next_event().unwrap();
            usart.tick(at);
            assert_eq!(usart.read(0, at).unwrap() & (RXNE | IDLE), RXNE);
            read.push(usart.read(4, at).unwrap());
        }
        // ten bits a byte
        assert_eq!(usart.next_event(), Some(1001 * (TICKS_PER_S * 10 / 115_200)));
        assert!(read.iter().any(|byte| *byte != read[0]));
        usart.flood(false, 0);
        while let Some(at) = usart.next_event() {
            usart.tick(at);
        }
        assert_eq!(usart.read(0, 0).unwrap() & IDLE, IDLE);
    }

    #[test]
    fn a_byte_that_the_line_loses_takes_its_time_all_the_same() {
        let mut usart = port(115_200);
        usart.set_noise(Some(LineNoise::new(1000, 0, 1)));
        usart.line_receives(b"xy", 0);
        usart.tick(usart.next_event().unwrap());
        let at = usart.next_event().unwrap();
        usart.tick(at);
        assert_eq!(at, 2 * (TICKS_PER_S * 10 / 115_200));
        assert_eq!(usart.read(0, at).unwrap() & (RXNE | FE), 0);
    }

    #[test]
    fn a_reset_does_not_reach_the_far_end() {
        let mut usart = port(57_600);
        usart.line_receives(b"xyz", 0);
        usart.reset();
        assert_eq!(usart.read(0x0c, 0).unwrap(), 0);
        assert_eq!(usart.next_event(), Some(TICKS_PER_S * 10 / 57_600));
        assert_eq!(usart.incoming.len(), 3);
    }

    #[test]
    fn the_wrong_baud_rate_is_heard() {
        let mut usart = port(57_600);
        usart.line_receives(b"x", 0);
        usart.tick(usart.next_event().unwrap());
        assert_eq!(usart.read(0, 0).unwrap() & FE, FE);
    }
}
