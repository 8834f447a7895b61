//! How far the reading of a file is, for whoever waits for it: a log of an hour takes seconds.

use std::cell::Cell;

/// Is called now and then with the bytes that were read so far, and all there are.
pub type ReadObserver<'a> = &'a dyn Fn(usize, usize);

/// Nobody waits.
pub(super) const UNOBSERVED: ReadObserver<'static> = &|_, _| ();

/// So often at most is it called in the course of a file: a row then costs one comparison more.
const REPORTS: usize = 200;

/// The way through the bytes of one file.
pub(super) struct Passage<'a> {
    observer: ReadObserver<'a>,
    bytes: usize,
    /// From this byte on the observer is called again.
    next: Cell<usize>,
}

impl<'a> Passage<'a> {
    /// Through so many bytes.
    pub(super) fn through(bytes: usize, observer: ReadObserver<'a>) -> Passage<'a> {
        Passage { observer, bytes, next: Cell::new(0) }
    }

    /// Everything before this byte was read.
    pub(super) fn is_at(&self, byte: usize) {
        if byte >= self.next.get() {
            self.next.set(byte + 1 + self.bytes / REPORTS);
            (self.observer)(byte, self.bytes);
        }
    }

    /// So many bytes are left.
    pub(super) fn is_before(&self, left: usize) {
        self.is_at(self.bytes - left);
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::path::Path;

    use super::super::fuzz_seeds::seeds;
    use super::super::parse_observed;
    use super::REPORTS;

    /// Each reader says how far it is, in order and up to the end of the file, and not for every row.
    #[test]
    fn every_reader_reports_the_way_through_its_file() {
        for (name, bytes) in seeds() {
            let (bytes_all, reports) = (bytes.len(), RefCell::new(Vec::new()));
            let read = parse_observed(Path::new(name), bytes, None, &|done, of| reports.borrow_mut().push((done, of)));
            assert!(read.is_ok(), "{name}");
            let reports = reports.into_inner();
            assert!((10..=REPORTS + 1).contains(&reports.len()), "{name}: {} reports", reports.len());
            assert!(reports.windows(2).all(|pair| pair[0].0 < pair[1].0), "{name}: {reports:?}");
            let (last, of) = reports[reports.len() - 1];
            assert!(last <= of && 10 * last > 9 * of && of <= bytes_all, "{name}: {last} of {of}");
        }
    }
}
