//! Logs over the link: listed, sent piece by piece, erased. <https://mavlink.io/en/messages/common.html#LOG_ENTRY>
//!
//! The ground leads: it asks for pieces, keeps what comes, and asks again for what did not, so that nothing needs to be
//! acknowledged. How that looks from its side (MAVProxy 1.8.75 `mavproxy_log.py`, QGroundControl's
//! `LogDownloadController`):
//!
//! - It asks for a log from a byte on, to a byte or for all, and when nothing comes for a while for up to twenty gaps
//!   at once. So pieces that are asked for wait in a queue, in their order; one that reaches the log's end, or is of
//!   another log, takes the place of all that wait, as the ground then begins anew.
//! - A piece of no bytes means to MAVProxy that all is there. So it is sent only to whoever asks for bytes at or beyond
//!   the end, which is what a ground does that misses nothing more; never at the end of a longer piece, which may have
//!   lost a part on the way.
//! - Ids count from 0, as PX4's do: QGroundControl takes those of all but ArduPilot as places in its list.
//!
//! Pieces are sent with what the line has left. While the vehicle is armed there are none.

use mavlink::MessageData;
use mavlink::dialects::common::{
    LOG_DATA_DATA, LOG_ENTRY_DATA, LOG_ERASE_DATA, LOG_REQUEST_DATA_DATA, LOG_REQUEST_END_DATA, LOG_REQUEST_LIST_DATA,
};

use super::frame::{Frame, FrameWriter, message};
use super::spare_room::SpareRoom;

/// Bytes of a log in one message.
pub const PIECE_BYTES: usize = 90;
/// Pieces that may wait: what MAVProxy asks for at once. What is beyond is asked for again.
const WAITING_MAX: usize = 20;

/// Where logs last.
pub trait LogStore {
    /// How many there are. Their ids count from 0, the oldest first.
    fn count(&mut self) -> u16;
    /// How long one is, bytes; 0 where there is none of this id.
    fn size_bytes(&mut self, id: u16) -> u32;
    /// Are the bytes from there on at hand? Where they have to be fetched first, that begins now, and the question is
    /// repeated until they are.
    fn is_ready(&mut self, _id: u16, _offset: u32) -> bool {
        true
    }
    /// Reads from a byte on, as much as there is and `piece` has room for; how much that is.
    fn read(&mut self, id: u16, offset: u32, piece: &mut [u8]) -> usize;
    /// Erases all.
    fn erase(&mut self);
}

/// Of a vehicle that keeps none.
#[derive(Clone, Copy, Debug)]
pub struct NoLogs;

impl LogStore for NoLogs {
    fn count(&mut self) -> u16 {
        0
    }

    fn size_bytes(&mut self, _: u16) -> u32 {
        0
    }

    fn read(&mut self, _: u16, _: u32, _: &mut [u8]) -> usize {
        0
    }

    fn erase(&mut self) {}
}

/// What the ground demands of the logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogRequest {
    /// List them.
    List {
        /// First id.
        first: u16,
        /// Last id.
        last: u16,
    },
    /// Send bytes of one.
    Send {
        /// Its id.
        id: u16,
        /// First byte.
        offset: u32,
        /// How many; the largest number means all that follow.
        count: u32,
    },
    /// Erase all.
    Erase,
    /// Send nothing more.
    End,
}

/// What a frame demands, with the system and the component that it is for.
pub(super) fn request_of(frame: &Frame) -> Option<([u8; 2], LogRequest)> {
    match frame.message_id {
        LOG_REQUEST_LIST_DATA::ID => message::<LOG_REQUEST_LIST_DATA>(frame).map(|data| {
            let request = LogRequest::List { first: data.start, last: data.end };
            ([data.target_system, data.target_component], request)
        }),
        LOG_REQUEST_DATA_DATA::ID => message::<LOG_REQUEST_DATA_DATA>(frame).map(|data| {
            let request = LogRequest::Send { id: data.id, offset: data.ofs, count: data.count };
            ([data.target_system, data.target_component], request)
        }),
        LOG_ERASE_DATA::ID => message::<LOG_ERASE_DATA>(frame)
            .map(|data| ([data.target_system, data.target_component], LogRequest::Erase)),
        LOG_REQUEST_END_DATA::ID => message::<LOG_REQUEST_END_DATA>(frame)
            .map(|data| ([data.target_system, data.target_component], LogRequest::End)),
        _ => None,
    }
}

/// Last byte of the CRC of the messages that demand something of the logs.
pub(super) fn crc_extra(message_id: u32) -> Option<u8> {
    match message_id {
        LOG_REQUEST_LIST_DATA::ID => Some(LOG_REQUEST_LIST_DATA::EXTRA_CRC),
        LOG_REQUEST_DATA_DATA::ID => Some(LOG_REQUEST_DATA_DATA::EXTRA_CRC),
        LOG_ERASE_DATA::ID => Some(LOG_ERASE_DATA::EXTRA_CRC),
        LOG_REQUEST_END_DATA::ID => Some(LOG_REQUEST_END_DATA::EXTRA_CRC),
        _ => None,
    }
}

/// Bytes of a log that are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Wanted {
    id: u16,
    /// First byte as it was asked for, by which a doubled request is known.
    asked: u32,
    /// First byte that was not sent yet.
    next: u32,
    /// The byte after the last.
    end: u32,
}

/// What is still to be listed and sent.
#[derive(Clone, Debug, Default)]
pub(super) struct LogDownload {
    /// Next and last id to be listed.
    listing: Option<(u16, u16)>,
    waiting: heapless::Deque<Wanted, WAITING_MAX>,
}

impl LogDownload {
    /// Takes a request.
    pub(super) fn take(&mut self, request: &LogRequest, store: &mut impl LogStore) {
        match *request {
            LogRequest::List { first, last } => self.listing = Some((first, last.max(first))),
            LogRequest::Send { id, offset, count } => {
                let size = store.size_bytes(id);
                let wanted = Wanted { id, asked: offset, next: offset, end: offset.saturating_add(count).min(size) };
                if self.waiting.iter().any(|one| one.id == id && one.asked == offset && one.end == wanted.end) {
                    return;
                }
                if wanted.end == size || self.waiting.iter().any(|one| one.id != id) {
                    self.waiting.clear();
                }
                let _ = self.waiting.push_back(wanted);
            }
            LogRequest::Erase => {
                self.stop();
                store.erase();
            }
            LogRequest::End => self.stop(),
        }
    }

    /// Sends nothing more.
    pub(super) fn stop(&mut self) {
        self.listing = None;
        self.waiting.clear();
    }

    /// Writes what there is room for, on the line and in `out`.
    pub(super) fn write<const N: usize>(
        &mut self,
        writer: &mut FrameWriter,
        store: &mut impl LogStore,
        room: &mut SpareRoom,
        out: &mut heapless::Vec<u8, N>,
    ) {
        while room.is_left() {
            let before = out.len();
            let written = if self.listing.is_some() {
                self.write_entry(writer, store, out)
            } else {
                self.write_piece(writer, store, out)
            };
            if !written {
                return;
            }
            room.use_up(out.len() - before);
        }
    }

    /// False where nothing is to be listed, or there is no room.
    fn write_entry<const N: usize>(
        &mut self,
        writer: &mut FrameWriter,
        store: &mut impl LogStore,
        out: &mut heapless::Vec<u8, N>,
    ) -> bool {
        let Some((next, last)) = self.listing else { return false };
        let count = store.count();
        let last_there = count.saturating_sub(1);
        // of no logs one entry says so; of a list that begins behind the last log the last
        let id = if next < last_there { next } else { last_there };
        let entry = LOG_ENTRY_DATA {
            // when it began is not known: the vehicle has no date
            time_utc: 0,
            size: store.size_bytes(id),
            id,
            num_logs: count,
            last_log_num: last_there,
        };
        let written = writer.write(&entry, out);
        if written {
            self.listing = (id < last && id < last_there).then(|| (id + 1, last));
        }
        written
    }

    /// False where nothing is to be sent, or there is no room.
    fn write_piece<const N: usize>(
        &mut self,
        writer: &mut FrameWriter,
        store: &mut impl LogStore,
        out: &mut heapless::Vec<u8, N>,
    ) -> bool {
        let Some(wanted) = self.waiting.front_mut() else { return false };
        if !store.is_ready(wanted.id, wanted.next) {
            return false;
        }
        let mut data = [0; PIECE_BYTES];
        let left = (wanted.end.saturating_sub(wanted.next) as usize).min(PIECE_BYTES);
        let count = data.get_mut(..left).map_or(0, |piece| store.read(wanted.id, wanted.next, piece).min(left));
        let piece = LOG_DATA_DATA { ofs: wanted.next, id: wanted.id, count: count as u8, data };
        if !writer.write(&piece, out) {
            return false;
        }
        wanted.next = wanted.next.saturating_add(count as u32);
        if count < PIECE_BYTES || wanted.next >= wanted.end {
            self.waiting.pop_front();
        }
        true
    }
}
