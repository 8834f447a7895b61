//! The files: JSON that describes the parameters, written anew from their table for each piece that is read.
//!
//! What is in them is MAVLink's: `general.schema.json` and `parameter.schema.json` of
//! <https://github.com/mavlink/mavlink/tree/master/component_metadata>. A file is a row of parts, each short, so that a
//! piece takes the writing of the parts that it lies in, and none of the file is kept.

use core::fmt::{Result, Write};

use crate::params::table::{Allowed, Counts, Field};
use crate::params::{Params, crc32_step};

/// Address of [`File::General`], as `COMPONENT_METADATA` has it.
pub(in crate::link) const GENERAL_ADDRESS: &str = "mftp:///general.json";

/// A file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum File {
    /// Which other files there are.
    General,
    /// What the parameters are.
    Parameters,
}

impl File {
    /// All of them, in the order of their folder.
    pub(super) const ALL: [File; 2] = [File::General, File::Parameters];

    pub(super) fn name(self) -> &'static str {
        match self {
            File::General => "general.json",
            File::Parameters => "parameters.json",
        }
    }

    pub(super) fn by_name(name: &[u8]) -> Option<File> {
        File::ALL.into_iter().find(|file| file.name().as_bytes() == name)
    }
}

/// Length of a file and its CRC, which is MAVLink's: CRC-32 with nothing inverted at start and end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Extent {
    pub(super) length: u32,
    pub(super) crc: u32,
}

impl Write for Extent {
    fn write_str(&mut self, text: &str) -> Result {
        for byte in text.bytes() {
            self.crc = crc32_step(self.crc, byte);
            self.length += 1;
        }
        Ok(())
    }
}

/// Keeps of what is written the bytes from one place on, as many as there is room for.
struct Window<'a> {
    at: u32,
    from: u32,
    piece: &'a mut [u8],
    kept: usize,
}

impl Write for Window<'_> {
    fn write_str(&mut self, text: &str) -> Result {
        for byte in text.bytes() {
            if self.at >= self.from
                && let Some(place) = self.piece.get_mut(self.kept)
            {
                *place = byte;
                self.kept += 1;
            }
            self.at += 1;
        }
        Ok(())
    }
}

/// What is known of the files.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Files {
    /// Of the parameters, as far as they were gone through.
    extent: Extent,
    /// The next part of them to go through.
    next_part: u8,
    /// Of the general file, once all of them were.
    general: Option<Extent>,
    /// A part of them and the byte at which it begins, so that who reads on does not begin with the first.
    found: (u8, u32),
}

impl Files {
    /// Goes through another part of the parameters, until all is known: at a call every 10 ms, 0.8 s after start.
    pub(super) fn survey(&mut self) {
        if self.general.is_some() {
            return;
        }
        // counting never fails
        if write_parameter_part(self.next_part, &mut self.extent).is_some() {
            self.next_part += 1;
        } else {
            let mut general = Extent::default();
            let _ = self.write_general(&mut general);
            self.general = Some(general);
        }
    }

    /// Length and CRC of a file, once they are known.
    pub(super) fn extent(&self, file: File) -> Option<Extent> {
        self.general.map(|general| match file {
            File::Parameters => self.extent,
            File::General => general,
        })
    }

    /// Reads from a byte on, as much as there is and `piece` has room for; how much that is.
    pub(super) fn read(&mut self, file: File, offset: u32, piece: &mut [u8]) -> usize {
        let wanted = piece.len();
        let mut window = Window { at: 0, from: offset, piece, kept: 0 };
        if file == File::General {
            let _ = self.write_general(&mut window);
            return window.kept;
        }
        let (mut part, start) = if self.found.1 <= offset { self.found } else { (0, 0) };
        window.at = start;
        while window.kept < wanted {
            if window.at <= offset {
                self.found = (part, window.at);
            }
            if write_parameter_part(part, &mut window).is_none() {
                break;
            }
            part += 1;
        }
        window.kept
    }

    fn write_general(&self, to: &mut dyn Write) -> Result {
        let (major, minor, patch) =
            (env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH"));
        let (uri, crc) = (File::Parameters.name(), self.extent.crc);
        write!(to, r#"{{"version":1,"firmwareVersion":"{major}.{minor}.{patch}","metadataTypes":[{{"type":1,"#)?;
        write!(to, r#""uri":"mftp:///{uri}","fileCrc":{crc}}}]}}"#)
    }
}

/// Writes a part of the file of the parameters: its head, an object for each, its end. None behind that.
fn write_parameter_part(part: u8, to: &mut dyn Write) -> Option<Result> {
    const LAST: usize = Field::ALL.len() + 1;
    match usize::from(part) {
        0 => Some(to.write_str(r#"{"version":3,"parameters":["#)),
        LAST => Some(to.write_str("]}")),
        part => Field::by_index(part - 1).map(|field| write_parameter(field, to)),
    }
}

fn write_parameter(field: Field, to: &mut dyn Write) -> Result {
    let row = field.row();
    let (least, most) = row.allowed.ends();
    let default = row.allowed.number(Params::DEFAULT.get(field));
    let comma = if field.index() == 0 { "" } else { "," };
    // as they go over the link: numbers of type REAL32, though all are whole
    write!(to, r#"{comma}{{"name":"{}","type":"Float","group":"{}","#, row.name, field.group())?;
    write!(to, r#""shortDesc":"{}","units":"{}","default":{default},"#, row.meaning, row.unit)?;
    write!(to, r#""min":{least},"max":{most},"decimalPlaces":0,"increment":1,"#)?;
    if let Allowed::Either(one, other) = row.allowed {
        write!(to, r#""values":[{{"value":{one},"description":"{one}"}},"#)?;
        write!(to, r#"{{"value":{other},"description":"{other}"}}],"#)?;
    }
    write!(to, r#""rebootRequired":{}}}"#, row.counts == Counts::NextStart)
}
