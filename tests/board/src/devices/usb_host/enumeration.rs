//! What an operating system asks a new device, and in what order (as Linux and Windows do): its descriptor as far as
//! one packet goes, a second reset, an address, all descriptors, a configuration.

use super::{Failure, Request};

/// The address that it gets.
const ADDRESS: u8 = 5;
/// Of a read from the device.
const GET_DESCRIPTOR: u8 = 6;
const FROM_DEVICE: u8 = 0x80;
/// American English, the one language that every host asks for.
const LANGUAGE: u16 = 0x0409;
/// Descriptor types (USB 2.0 table 9-5).
const DEVICE: u16 = 1;
const CONFIGURATION: u16 = 2;
const STRING: u16 = 3;
const INTERFACE: u8 = 4;
const ENDPOINT: u8 = 5;
const QUALIFIER: u16 = 6;
/// Communications class.
const CDC: u8 = 2;
const BULK: u8 = 2;
const TO_HOST: u8 = 0x80;

/// A device that is configured.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Enumerated {
    /// Its device descriptor.
    pub device: Vec<u8>,
    /// Its configuration with all that belongs to it.
    pub configuration: Vec<u8>,
    /// Manufacturer, product, serial number.
    pub strings: [String; 3],
    /// The interface of the communications class.
    pub control_interface: u8,
    /// Endpoints for bytes, with their packets' length.
    pub bulk_in: Option<(usize, usize)>,
    /// The same towards the device.
    pub bulk_out: Option<(usize, usize)>,
}

/// What is done next.
pub(super) enum Next {
    Reset { packet_bytes: usize },
    Request(Request),
    Addressed(u8, Request),
    Done,
}

/// How far it has got.
#[derive(Clone, Debug, Default)]
pub(super) struct Enumeration {
    step: usize,
    found: Enumerated,
    failed: bool,
}

const STEPS: usize = 11;

impl Enumeration {
    pub(super) fn done(&self) -> Option<&Enumerated> {
        (self.step == STEPS && !self.failed).then_some(&self.found)
    }

    /// The first request behind the first reset, or the second.
    pub(super) fn after_reset(&mut self) -> Request {
        if self.step == 0 { descriptor(DEVICE, 0, 0, 64) } else { Request::write(0, 5, ADDRESS.into(), 0, &[]) }
    }

    /// What follows from a request that is over, if it was one of these.
    pub(super) fn take(&mut self, request: &Request, result: &Result<Vec<u8>, Failure>) -> Option<Next> {
        if self.failed || self.step == STEPS {
            return None;
        }
        let is_qualifier = request.code == GET_DESCRIPTOR && request.value == QUALIFIER << 8;
        let bytes = match result {
            Ok(bytes) => bytes.clone(),
            // a device of full speed alone has no other speed to tell of (section 9.6.2)
            Err(Failure::Stalled) if is_qualifier => Vec::new(),
            Err(_) => {
                self.failed = true;
                return None;
            }
        };
        let next = self.follow(&bytes);
        self.step += 1;
        self.failed = next.is_none();
        next
    }

    fn follow(&mut self, bytes: &[u8]) -> Option<Next> {
        let string = |place: usize, found: &Enumerated| descriptor(STRING, found.device[13 + place], LANGUAGE, 255);
        Some(match self.step {
            0 => Next::Reset { packet_bytes: (*bytes.get(7)?).into() },
            1 => Next::Addressed(ADDRESS, descriptor(DEVICE, 0, 0, 18)),
            2 => {
                self.found.device = bytes.to_vec();
                bytes.get(17)?;
                Next::Request(descriptor(QUALIFIER, 0, 0, 10))
            }
            3 => Next::Request(descriptor(CONFIGURATION, 0, 0, 9)),
            4 => Next::Request(descriptor(CONFIGURATION, 0, 0, u16::from_le_bytes([*bytes.get(2)?, *bytes.get(3)?]))),
            5 => {
                self.found.configuration = bytes.to_vec();
                self.find_endpoints();
                Next::Request(descriptor(STRING, 0, 0, 255))
            }
            // manufacturer, product and serial number are bytes 14 to 16 of the device descriptor
            6 => Next::Request(string(1, &self.found)),
            7 | 8 => {
                self.found.strings[self.step - 7] = text(bytes)?;
                Next::Request(string(self.step - 5, &self.found))
            }
            9 => {
                self.found.strings[2] = text(bytes)?;
                Next::Request(Request::write(0, 9, (*self.found.configuration.get(5)?).into(), 0, &[]))
            }
            _ => Next::Done,
        })
    }

    /// The communications interface, and the first endpoints for bytes in each direction.
    fn find_endpoints(&mut self) {
        let mut rest = self.found.configuration.as_slice();
        while let [length, kind, ..] = *rest
            && length >= 2
            && usize::from(length) <= rest.len()
        {
            let (this, next) = rest.split_at(length.into());
            match (kind, this) {
                (INTERFACE, [_, _, number, _, _, CDC, ..]) => self.found.control_interface = *number,
                (ENDPOINT, [_, _, address, attributes, low, high, ..]) if attributes & 3 == BULK => {
                    let found = Some((usize::from(address & 0xf), u16::from_le_bytes([*low, *high]).into()));
                    let place = if address & TO_HOST != 0 { &mut self.found.bulk_in } else { &mut self.found.bulk_out };
                    *place = place.or(found);
                }
                _ => {}
            }
            rest = next;
        }
    }
}

fn descriptor(kind: u16, index: u8, language: u16, length: u16) -> Request {
    Request::read(FROM_DEVICE, GET_DESCRIPTOR, kind << 8 | u16::from(index), language, length)
}

/// A string descriptor's text (section 9.6.7).
fn text(bytes: &[u8]) -> Option<String> {
    let [length, 3, units @ ..] = bytes else { return None };
    let units: Vec<u16> = units.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    (usize::from(*length) == bytes.len()).then(|| String::from_utf16(&units).ok()).flatten()
}
