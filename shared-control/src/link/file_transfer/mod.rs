//! MAVLink FTP, to read: the files that describe the parameters. <https://mavlink.io/en/services/ftp.html>
//!
//! A ground station finds the first by `COMPONENT_METADATA`
//! (<https://mavlink.io/en/services/component_metadata.html>), and there where the parameters are described. Nothing is
//! written, nothing belongs to the flight, so it is served armed and disarmed alike, with what the line has left.
//!
//! - Each of up to four who ask, known by system and component, may have one file open; opening another closes it. Who
//!   was silent longest makes room for a fifth, once that is [`FORGOTTEN_AFTER_US`].
//! - A request that comes again, because the answer was lost, has the same answer: bytes and sizes do not change, who
//!   opens twice is given the same session, and who closes twice hears that it is closed.
//! - A burst is pieces of the size that is wanted, or of what there is room for, up to 24 of them or the file's
//!   end; its answers' numbers go up by one. The last says that it is complete; whoever asks on there has the next
//!   burst, or behind the end hears of it.

mod files;
mod request;

use mavlink::MessageData;
use mavlink::dialects::common::FILE_TRANSFER_PROTOCOL_DATA;

use super::frame::{CRC_LEN, FrameWriter, HEADER_LEN};
use super::signing::signature::SIGNATURE_LEN;
use super::spare_room::SpareRoom;
pub(super) use files::GENERAL_ADDRESS;
use files::{File, Files};
pub use request::FileRequest;
use request::{DATA_MAX, HEAD_AT, HEAD_LEN, Place};

/// Most bytes of a file in one message: what finds room beside a usual report in a buffer of 280 bytes.
const PIECE_BYTES: usize = 128;
/// Bytes of a message before its piece, and behind it.
const AROUND_PIECE: usize = HEADER_LEN + HEAD_AT + HEAD_LEN + CRC_LEN + SIGNATURE_LEN;
/// Pieces of a burst: a second's worth at 57,600 baud. Of one that takes much longer pymavlink's `mavftp` believes that
/// the vehicle is silent, since it counts from what it sent itself (3.7 s).
const BURST_PIECES: u8 = 24;
/// Numbers by which a request may be older than one that came before it: a network that swaps neighbours, whose sender
/// asks for the next before it has an answer.
const OVERTAKEN_MAX: u16 = 4;
/// Requests that may wait; what is beyond is asked for again.
const WAITING_MAX: usize = 8;
/// Who may have a file open at once.
const CLIENTS_MAX: usize = 4;
/// Silence after which a client makes room for another, µs.
pub const FORGOTTEN_AFTER_US: u64 = 10_000_000;

/// What is to be done, by its number.
mod opcode {
    pub(super) const NOTHING: u8 = 0;
    pub(super) const CLOSE: u8 = 1;
    pub(super) const CLOSE_ALL: u8 = 2;
    pub(super) const LIST: u8 = 3;
    pub(super) const OPEN: u8 = 4;
    pub(super) const READ: u8 = 5;
    /// All from here to [`WRITES_LAST`] make, change or remove something.
    pub(super) const WRITES_FIRST: u8 = 6;
    pub(super) const WRITES_LAST: u8 = 13;
    pub(super) const CRC: u8 = 14;
    pub(super) const BURST: u8 = 15;
    /// Answers.
    pub(super) const ACK: u8 = 128;
    pub(super) const NAK: u8 = 129;
}

/// Why something is not done; the numbers are the protocol's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refused {
    BadSize = 3,
    NoSuchSession = 4,
    AllSessionsTaken = 5,
    EndOfFile = 6,
    UnknownCommand = 7,
    ReadOnly = 9,
    NotFound = 10,
}

/// Who asks.
#[derive(Clone, Copy, Debug)]
struct Client {
    asker: [u8; 2],
    heard_us: u64,
    /// And the number of the request that opened it.
    open: Option<(File, u16)>,
    /// Number of the request that closed one last.
    closed_by: Option<u16>,
    burst: Option<Burst>,
}

/// A burst under way.
#[derive(Clone, Copy, Debug)]
struct Burst {
    file: File,
    /// Number of the next answer.
    sequence: u16,
    /// Bytes of a piece.
    size: u8,
    /// Next byte.
    offset: u32,
    /// Pieces that may still follow, the next one included.
    left: u8,
}

/// An answer.
#[derive(Clone, Debug)]
struct Reply {
    sequence: u16,
    session: u8,
    opcode: u8,
    answered: u8,
    burst_complete: bool,
    offset: u32,
    data: heapless::Vec<u8, PIECE_BYTES>,
}

/// The service.
#[derive(Clone, Debug, Default)]
pub(super) struct FileTransfer {
    files: Files,
    clients: [Option<Client>; CLIENTS_MAX],
    waiting: heapless::Deque<FileRequest, WAITING_MAX>,
}

impl FileTransfer {
    /// To be called every now and then until sizes and CRCs are known; nothing is answered before.
    pub(super) fn survey(&mut self) {
        self.files.survey();
    }

    /// CRC of the file at [`GENERAL_ADDRESS`], once it is known.
    pub(super) fn general_crc(&self) -> Option<u32> {
        self.files.extent(File::General).map(|extent| extent.crc)
    }

    /// Takes a request.
    pub(super) fn take(&mut self, request: &FileRequest) {
        let _ = self.waiting.push_back(*request);
    }

    /// Writes what there is room for, on the line and in `out`.
    pub(super) fn write<const N: usize>(
        &mut self,
        writer: &mut FrameWriter,
        time_us: u64,
        room: &mut SpareRoom,
        out: &mut heapless::Vec<u8, N>,
    ) {
        let piece_max = PIECE_BYTES.min(N.saturating_sub(AROUND_PIECE));
        while room.is_left() {
            let before = out.len();
            // answers first, so that a burst can be ended
            let written = match self.waiting.front().copied() {
                Some(request) => self.answer(&request, time_us, piece_max).is_some_and(|reply| {
                    let written = write_reply(&reply, request.asker, writer, out);
                    if written {
                        self.waiting.pop_front();
                    }
                    written
                }),
                None => self.write_burst(piece_max, writer, out),
            };
            if !written {
                return;
            }
            room.use_up(out.len() - before);
        }
    }

    /// None while the files are not known yet. May be made several times, until there is room for it.
    fn answer(&mut self, request: &FileRequest, time_us: u64, piece_max: usize) -> Option<Reply> {
        self.files.extent(File::General)?;
        let mut reply = Reply {
            sequence: request.sequence.wrapping_add(1),
            session: request.session,
            opcode: opcode::ACK,
            answered: request.opcode,
            burst_complete: false,
            offset: request.offset,
            data: heapless::Vec::new(),
        };
        if let Err(refused) = self.fulfil(request, time_us, piece_max, &mut reply) {
            reply.opcode = opcode::NAK;
            reply.data.clear();
            let _ = reply.data.push(refused as u8);
        }
        Some(reply)
    }

    fn fulfil(
        &mut self,
        request: &FileRequest,
        time_us: u64,
        piece_max: usize,
        reply: &mut Reply,
    ) -> Result<(), Refused> {
        if request.size > DATA_MAX {
            return Err(Refused::BadSize);
        }
        match request.opcode {
            opcode::NOTHING => Ok(()),
            opcode::CLOSE_ALL => {
                if let Some(client) = self.known(request.asker, time_us) {
                    client.close(request.sequence);
                }
                Ok(())
            }
            opcode::CLOSE => {
                let client = self.with_session(request, time_us)?;
                let is_repeated = client.closed_by == Some(request.sequence);
                if client.open.is_none() && !is_repeated {
                    return Err(Refused::NoSuchSession);
                }
                client.close(request.sequence);
                Ok(())
            }
            opcode::LIST => list(&self.files, request, reply),
            opcode::OPEN => self.open(request, time_us, reply),
            opcode::READ => {
                let (file, _) = self.with_session(request, time_us)?.open.ok_or(Refused::NoSuchSession)?;
                let piece = usize::from(request.size).min(piece_max);
                read_piece(&mut self.files, (file, request.offset), piece, reply)
            }
            opcode::BURST => {
                let (file, _) = self.with_session(request, time_us)?.open.ok_or(Refused::NoSuchSession)?;
                let size = if request.size == 0 { DATA_MAX } else { request.size };
                let piece = usize::from(size).min(piece_max);
                let (sequence, offset) = (request.sequence.wrapping_add(1), request.offset);
                let burst = Burst { file, sequence, size: piece as u8, offset, left: BURST_PIECES };
                read_piece(&mut self.files, (file, offset), piece, reply)?;
                let next = self.next_of(burst, reply);
                if let Some(client) = self.known(request.asker, time_us) {
                    client.burst = next;
                }
                Ok(())
            }
            opcode::CRC => {
                let Place::File(file) = request.place else { return Err(Refused::NotFound) };
                let extent = self.files.extent(file).unwrap_or_default();
                let _ = reply.data.extend_from_slice(&extent.crc.to_le_bytes());
                Ok(())
            }
            opcode::WRITES_FIRST..=opcode::WRITES_LAST => Err(Refused::ReadOnly),
            _ => Err(Refused::UnknownCommand),
        }
    }

    fn open(&mut self, request: &FileRequest, time_us: u64, reply: &mut Reply) -> Result<(), Refused> {
        let Place::File(file) = request.place else { return Err(Refused::NotFound) };
        let session = self.session_for(request.asker, time_us).ok_or(Refused::AllSessionsTaken)?;
        if let Some(place) = self.clients.get_mut(session) {
            let (asker, open) = (request.asker, Some((file, request.sequence)));
            let before = place.filter(|client| client.asker == asker);
            // where it comes again, late, what has begun goes on
            if before.is_none_or(|client| client.open != open) {
                let closed_by = before.and_then(|client| client.closed_by);
                *place = Some(Client { asker, heard_us: time_us, open, closed_by, burst: None });
            }
        }
        reply.session = session as u8;
        let extent = self.files.extent(file).unwrap_or_default();
        let _ = reply.data.extend_from_slice(&extent.length.to_le_bytes());
        Ok(())
    }

    /// The session of who asks, or a free one, or that of whoever was silent for long.
    fn session_for(&self, asker: [u8; 2], time_us: u64) -> Option<usize> {
        let place_of = |which: &dyn Fn(&Option<Client>) -> bool| self.clients.iter().position(which);
        place_of(&|place| place.is_some_and(|client| client.asker == asker))
            .or_else(|| place_of(&|place| place.is_none_or(|client| client.open.is_none())))
            .or_else(|| {
                let is_silent = |client: Client| time_us.saturating_sub(client.heard_us) > FORGOTTEN_AFTER_US;
                place_of(&|place| place.is_some_and(is_silent))
            })
    }

    fn known(&mut self, asker: [u8; 2], time_us: u64) -> Option<&mut Client> {
        let client = self.clients.iter_mut().flatten().find(|client| client.asker == asker)?;
        client.heard_us = time_us;
        Some(client)
    }

    /// Whoever has this session.
    fn with_session(&mut self, request: &FileRequest, time_us: u64) -> Result<&mut Client, Refused> {
        let place = self.clients.get_mut(usize::from(request.session)).and_then(Option::as_mut);
        let client = place.filter(|client| client.asker == request.asker).ok_or(Refused::NoSuchSession)?;
        client.heard_us = time_us;
        Ok(client)
    }

    /// The burst after this answer of it; none where that was the last, which then says so.
    fn next_of(&self, burst: Burst, reply: &mut Reply) -> Option<Burst> {
        let offset = burst.offset.saturating_add(reply.data.len() as u32);
        let length = self.files.extent(burst.file).unwrap_or_default().length;
        let left = burst.left.saturating_sub(1);
        reply.burst_complete = offset >= length || left == 0;
        let sequence = burst.sequence.wrapping_add(1);
        (!reply.burst_complete).then_some(Burst { sequence, offset, left, ..burst })
    }

    /// False where there is no burst, or no room.
    fn write_burst<const N: usize>(
        &mut self,
        piece_max: usize,
        writer: &mut FrameWriter,
        out: &mut heapless::Vec<u8, N>,
    ) -> bool {
        let bursts = self.clients.iter().enumerate();
        let Some((session, asker, burst)) =
            bursts.filter_map(|(at, client)| client.and_then(|client| Some((at, client.asker, client.burst?)))).next()
        else {
            return false;
        };
        let mut reply = Reply {
            sequence: burst.sequence,
            session: session as u8,
            opcode: opcode::ACK,
            answered: opcode::BURST,
            burst_complete: false,
            offset: burst.offset,
            data: heapless::Vec::new(),
        };
        let piece = usize::from(burst.size).min(piece_max);
        // it ends before the file's end
        let _ = read_piece(&mut self.files, (burst.file, burst.offset), piece, &mut reply);
        let next = self.next_of(burst, &mut reply);
        let written = write_reply(&reply, asker, writer, out);
        if written && let Some(Some(client)) = self.clients.get_mut(session) {
            client.burst = next;
        }
        written
    }
}

impl Client {
    /// A request that comes again, late, does not close what was opened since, nor does one that the opening has
    /// overtaken on the way.
    fn close(&mut self, by: u16) {
        let overtaken_by = self.open.map_or(0, |(_, opened_by)| opened_by.wrapping_sub(by));
        if self.closed_by != Some(by) && !(1..=OVERTAKEN_MAX).contains(&overtaken_by) {
            (self.open, self.burst, self.closed_by) = (None, None, Some(by));
        }
    }
}

/// Entries of the folder from one on: `F`, the name, a tabulator and the size, each ended by a zero.
fn list(files: &Files, request: &FileRequest, reply: &mut Reply) -> Result<(), Refused> {
    use core::fmt::Write;
    if request.place != Place::Root {
        return Err(Refused::NotFound);
    }
    for file in File::ALL.into_iter().skip(request.offset.try_into().unwrap_or(usize::MAX)) {
        let mut entry = heapless::String::<32>::new();
        let length = files.extent(file).unwrap_or_default().length;
        // there is room for both
        let _ = write!(entry, "F{}\t{length}\0", file.name());
        let _ = reply.data.extend_from_slice(entry.as_bytes());
    }
    if reply.data.is_empty() { Err(Refused::EndOfFile) } else { Ok(()) }
}

/// At or behind the file's end there is nothing to read.
fn read_piece(files: &mut Files, (file, offset): (File, u32), bytes: usize, reply: &mut Reply) -> Result<(), Refused> {
    let mut piece = [0; PIECE_BYTES];
    let read = piece.get_mut(..bytes).map_or(0, |piece| files.read(file, offset, piece));
    if read == 0 && files.extent(file).unwrap_or_default().length <= offset {
        return Err(Refused::EndOfFile);
    }
    let _ = reply.data.extend_from_slice(piece.get(..read).unwrap_or_default());
    Ok(())
}

/// False if there was no room.
fn write_reply<const N: usize>(
    reply: &Reply,
    [system, component]: [u8; 2],
    writer: &mut FrameWriter,
    out: &mut heapless::Vec<u8, N>,
) -> bool {
    let [sequence0, sequence1] = reply.sequence.to_le_bytes();
    let [offset0, offset1, offset2, offset3] = reply.offset.to_le_bytes();
    #[rustfmt::skip]
    let head = [
        0, system, component,
        sequence0, sequence1, reply.session, reply.opcode, reply.data.len() as u8, reply.answered,
        reply.burst_complete.into(), 0, offset0, offset1, offset2, offset3,
    ];
    let mut payload = heapless::Vec::<u8, { HEAD_AT + HEAD_LEN + PIECE_BYTES }>::new();
    // there is room for all of it
    let _ = payload.extend_from_slice(&head);
    let _ = payload.extend_from_slice(&reply.data);
    let message = (FILE_TRANSFER_PROTOCOL_DATA::ID, FILE_TRANSFER_PROTOCOL_DATA::EXTRA_CRC);
    writer.write_payload(message, &payload, out)
}
