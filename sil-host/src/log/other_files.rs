//! Files that people take for logs and that are none: what each is by its first bytes, and how a log is made of it.

/// First bytes, where they begin, and what to do.
const KNOWN: [(usize, &[u8], &str); 11] = [
    (0, b"%PDF", "a PDF document, no log"),
    (0, b"\x89PNG", "a picture, no log"),
    (0, b"\xff\xd8\xff", "a picture, no log"),
    (0, b"PK\x03\x04", "a zip archive or a spreadsheet: unpack it, or save it as CSV"),
    (0, b"7z\xbc\xaf", "an archive: unpack it"),
    (0, b"\xfd7zXZ", "compressed by xz: unpack it (gzip is read as it is)"),
    (0, b"MATLAB 5.0", "a MATLAB file: write a CSV of it (writetable)"),
    (0, b"\x89HDF", "an HDF5 or MATLAB 7.3 file: write a CSV of it"),
    (0, b"#ROSBAG", "a ROS bag: write a CSV of its topics"),
    // 8 bytes of time before each packet
    (8, b"\xfd", TELEMETRY),
    (8, b"\xfe", TELEMETRY),
];

const TELEMETRY: &str = "a telemetry log (tlog) of a ground station, too slow for a vehicle's motion: take the flight \
                         controller's own log (.ulg, .bin)";

/// What such a file is; `None` for one that may be a log.
pub(super) fn what_it_is(bytes: &[u8]) -> Option<&'static str> {
    // names and numbers in the first lines speak for a table, whatever their letters
    let is_text = bytes.iter().take(64).all(|byte| matches!(byte, b'\t' | b'\r' | b'\n' | b' '..=b'~'));
    let begins = |(from, magic, _): &&(usize, &[u8], &str)| bytes.get(*from..).is_some_and(|at| at.starts_with(magic));
    if let Some((from, _, what)) = KNOWN.iter().find(begins)
        && (*from == 0 || !is_text)
    {
        return Some(what);
    }
    if bytes.len() > 1 && bytes.iter().all(|byte| *byte == 0) {
        return Some("nothing but zeros: the logger never wrote to it, or the copy failed");
    }
    let head: String = bytes.iter().take(256).map(|byte| byte.to_ascii_lowercase() as char).collect();
    match head.trim_start() {
        head if head.starts_with("<!doctype html") || head.starts_with("<html") => {
            Some("a web page, no log: the download may have failed")
        }
        head if ["{", "[{", "[["].iter().any(|start| head.starts_with(start)) => {
            Some("JSON: write a CSV of it, a row for each time")
        }
        _ => None,
    }
}
