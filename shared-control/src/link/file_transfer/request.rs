//! A request as it comes: <https://mavlink.io/en/services/ftp.html>.

use super::files::File;
use crate::link::frame::Frame;

/// Where the protocol's own bytes begin in the message, behind network, system and component.
pub(super) const HEAD_AT: usize = 3;
/// How many they are; data follow.
pub(super) const HEAD_LEN: usize = 12;
/// Most bytes of data in a message.
pub(super) const DATA_MAX: u8 = 239;

/// What a path leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The folder that holds all files.
    Root,
    /// A file.
    File(File),
    /// Nothing that is there.
    Nowhere,
}

impl Place {
    /// With or without the slash at its beginning.
    fn of(path: &[u8]) -> Place {
        match path.strip_prefix(b"/").unwrap_or(path) {
            b"" | b"." => Place::Root,
            name => File::by_name(name).map_or(Place::Nowhere, Place::File),
        }
    }
}

/// What somebody demands of the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileRequest {
    /// System and component that want it.
    pub(super) asker: [u8; 2],
    /// Number of the request; the answer has the next.
    pub(super) sequence: u16,
    /// The open file that is meant.
    pub(super) session: u8,
    /// What to do.
    pub(super) opcode: u8,
    /// How many bytes: wanted where bytes are read, else those of the path.
    pub(super) size: u8,
    /// First byte that is wanted; of a folder the first entry.
    pub(super) offset: u32,
    /// What its path leads to.
    pub(super) place: Place,
}

impl FileRequest {
    /// The request in a `FILE_TRANSFER_PROTOCOL`, with the system and the component that it is for. Zeros at the end of
    /// the message are not sent, so what is not there is zero.
    pub fn of(frame: &Frame) -> ([u8; 2], FileRequest) {
        let byte = |at: usize| frame.payload.get(at).copied().unwrap_or_default();
        let head = |at: usize| byte(HEAD_AT + at);
        let size = head(4);
        let data = frame.payload.get(HEAD_AT + HEAD_LEN..).unwrap_or_default();
        let path = data.get(..usize::from(size)).unwrap_or(data);
        // some send the zero that ends a string in C along
        let path = path.split(|byte| *byte == 0).next().unwrap_or_default();
        let request = FileRequest {
            asker: [frame.system_id, frame.component_id],
            sequence: u16::from_le_bytes([head(0), head(1)]),
            session: head(2),
            opcode: head(3),
            size,
            offset: u32::from_le_bytes([head(8), head(9), head(10), head(11)]),
            place: Place::of(path),
        };
        ([byte(1), byte(2)], request)
    }
}
