//! SDIO's pins and the card in the slot.

use super::wiring::SDIO_DMA;
use super::{Board, C, D};
use crate::devices::sd_card::{BlockStatus, Response};
use crate::memory::Memory;
use crate::peripherals::Peripheral;
use crate::peripherals::sdio::{Outgoing, Width};
use crate::stop::Cause;
use crate::time::Ticks;

/// Clock, command, data lines 0 to 3; all alternate function 12.
const CLOCK: (usize, u32) = (C, 12);
const COMMAND: (usize, u32) = (D, 2);
const DATA: [(usize, u32); 4] = [(C, 8), (C, 9), (C, 10), (C, 11)];
const SDIO_FUNCTION: Option<u32> = Some(12);

/// The card's first bit comes when nobody waits for it.
const BLOCK_MISSED: &str = "the SD card sends before the controller waits for a block";
/// Its blocks are of another length.
const BLOCK_LENGTH: &str = "the SD card sends blocks of another length than the controller is set to";

impl Board {
    pub(super) fn tick_card(&mut self, now: Ticks, memory: &mut dyn Memory) {
        self.move_blocks(memory);
        loop {
            self.begin_block(now);
            let before = self.sdio.next_event();
            self.sdio.tick(now);
            self.move_blocks(memory);
            match self.sdio.outgoing(now) {
                Some(Outgoing::Command { index, argument, at }) => {
                    let response = self.ask_card(index, argument, at);
                    self.sdio.respond(response);
                }
                Some(Outgoing::Block { bytes, at }) => {
                    let status = self.hand_block(&bytes, at);
                    self.sdio.block_status(status);
                }
                None if self.sdio.next_event() == before && self.card_event().is_none_or(|at| at > now) => return,
                None => {}
            }
        }
    }

    pub(super) fn card_event(&self) -> Option<Ticks> {
        let awaited = self.sdio.awaits_block().is_some();
        let begins = self.card.as_ref().and_then(|card| card.sends()).map(|(at, _)| at).filter(|_| awaited);
        self.sdio.next_event().into_iter().chain(begins).min()
    }

    fn move_blocks(&mut self, memory: &mut dyn Memory) {
        self.move_items(&SDIO_DMA, memory);
        if self.sdio.take_last_word() {
            self.dma[1].peripheral_ended(3);
            self.dma[1].peripheral_ended(6);
        }
    }

    fn card_line_is_wired(&self, (port, pin): (usize, u32)) -> bool {
        self.ports[port].alternate_function(pin) == SDIO_FUNCTION
    }

    /// Do card and controller use the same data lines, and do those lead from one to the other?
    fn data_lines_fit(&self) -> bool {
        let wide = self.sdio.width() == Width::Four;
        let lines = &DATA[..self.sdio.width() as usize];
        self.card.as_ref().is_some_and(|card| card.is_wide() == wide)
            && lines.iter().all(|pin| self.card_line_is_wired(*pin))
    }

    fn check_card_clock(&mut self, at: Ticks) {
        let cycle = self.sdio.cycle();
        let kept = self.card.as_ref().map_or(Ok(()), |card| card.check_clock(cycle));
        self.keep_rule(kept, at);
    }

    fn ask_card(&mut self, index: u8, argument: u32, at: Ticks) -> Response {
        let wired = self.card_line_is_wired(CLOCK) && self.card_line_is_wired(COMMAND);
        self.check_card_clock(at);
        match &mut self.card {
            Some(card) if wired => card.command(index, argument, at),
            _ => Response::None,
        }
    }

    fn hand_block(&mut self, bytes: &[u8], at: Ticks) -> BlockStatus {
        let fits = self.data_lines_fit();
        let taken = match &mut self.card {
            Some(card) if card.is_removed() => Ok(BlockStatus::None),
            // what comes over other lines has no CRC that fits
            Some(_) if !fits => Ok(BlockStatus::Refused),
            Some(card) => card.receive_block(bytes, at),
            None => Ok(BlockStatus::None),
        };
        taken.unwrap_or_else(|rule| {
            self.break_rule(rule, at);
            BlockStatus::None
        })
    }

    /// The card begins a block, if it sends one by now.
    fn begin_block(&mut self, now: Ticks) {
        let Some(since) = self.sdio.awaits_block() else { return };
        let Some((at, length)) = self.card.as_ref().and_then(|card| card.sends()).filter(|(at, _)| *at <= now) else {
            return;
        };
        let why = match at < since {
            true => Some(BLOCK_MISSED),
            false => (length != self.sdio.block_bytes() as usize).then_some(BLOCK_LENGTH),
        };
        if let Some(why) = why {
            self.refuse(Cause::Unmodelled(why), 0, None);
            return;
        }
        self.check_card_clock(at);
        let (fits, end) = (self.data_lines_fit(), at + self.sdio.block_ticks(length));
        if let Some(card) = &mut self.card {
            let bytes = card.send_block(end);
            self.sdio.receive_block(&bytes, at, fits);
        }
    }
}

#[cfg(test)]
mod tests;
