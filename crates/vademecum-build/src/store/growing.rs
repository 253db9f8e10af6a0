//! A text that grows in place, whole lines at a time: what was computed before a stop is there.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::time::{Duration, Instant};

/// Lines wait for others at most this long.
const DUE: Duration = Duration::from_millis(500);
/// Lines that wait take at most about this much memory \[bytes\].
const ROOM: usize = 1 << 16;
/// A system writes memory to a file page by page, and a kill may fall between two of them.
const PAGE: u64 = 4096;

/// A text of lines between a head and a tail. After each write the file is whole: head, lines, tail. It is
/// left so by whatever ends the program.
#[derive(Debug)]
pub struct GrowingFile {
    file: File,
    /// Length of head and lines in the file; `None` for a pipe or a device, which cannot go back.
    whole: Option<u64>,
    /// Length of what went through a pipe or to a device.
    sent: u64,
    tail: &'static str,
    waiting: Vec<u8>,
    /// Length of the longest line so far.
    longest: usize,
    lines: usize,
    written: Instant,
    failed: bool,
}

impl GrowingFile {
    /// Begins the text in a new file, or in a pipe or a device (`goes_back` is false).
    pub(super) fn begin(file: File, goes_back: bool, head: &str, tail: &'static str) -> io::Result<Self> {
        let mut begun = Self {
            file,
            whole: goes_back.then_some(0),
            sent: 0,
            tail,
            waiting: head.into(),
            longest: head.len(),
            lines: 0,
            written: Instant::now(),
            failed: false,
        };
        begun.write_waiting()?;
        begun.lines = 0;
        Ok(begun)
    }

    /// Adds a line, its end included. It is on the disk within about half a second, if this or [`Self::tick`]
    /// is called.
    ///
    /// # Errors
    /// The error of the system (full disk). The file then ends with its last whole line.
    pub fn add(&mut self, line: &str) -> io::Result<()> {
        self.waiting.extend_from_slice(line.as_bytes());
        self.longest = self.longest.max(line.len());
        self.fill_page();
        self.tick()
    }

    /// Fills a page with zeros behind the last digit of its last line, as in `1.500e3` for `1.5e3`, if the
    /// next line might not have room in it: so no line crosses two pages, and a kill between them leaves
    /// whole lines.
    fn fill_page(&mut self) {
        let place = self.whole.unwrap_or(self.sent) + self.waiting.len() as u64;
        let room = (PAGE - place % PAGE) as usize;
        if !self.tail.is_empty() || room >= self.longest {
            return;
        }
        let exponent =
            self.waiting.iter().rposition(|&byte| !(b"-\n".contains(&byte) || byte.is_ascii_digit()));
        if let Some(place) = exponent.filter(|&place| self.waiting[place] == b'e') {
            self.waiting.splice(place..place, std::iter::repeat_n(b'0', room));
        }
    }

    /// Writes the lines that have waited long enough.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn tick(&mut self) -> io::Result<()> {
        if !self.waiting.is_empty() && (self.waiting.len() > ROOM || self.written.elapsed() > DUE) {
            return self.write_waiting();
        }
        Ok(())
    }

    /// Lines in the file, the head not counted.
    pub fn lines(&self) -> usize {
        self.lines
    }

    /// Writes the lines that wait. After an error there are none.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn flush(&mut self) -> io::Result<()> {
        if self.failed || self.waiting.is_empty() { Ok(()) } else { self.write_waiting() }
    }

    /// Ends the text: nothing is left to do but what still waits, and the tail of a text that went through a
    /// pipe.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn finish(&mut self) -> io::Result<()> {
        self.flush()?;
        let through = self.whole.is_none() && !self.failed;
        if through { self.file.write_all(self.tail.as_bytes()) } else { Ok(()) }
    }

    fn write_waiting(&mut self) -> io::Result<()> {
        self.written = Instant::now();
        let lines = std::mem::take(&mut self.waiting);
        let Some(whole) = self.whole else {
            self.lines += count(&lines);
            self.sent += lines.len() as u64;
            return self.file.write_all(&lines).inspect_err(|_| self.failed = true);
        };
        let text = [&lines, self.tail.as_bytes()].concat();
        self.file.seek(SeekFrom::Start(whole))?;
        let (written, result) = write_counted(&mut self.file, whole, &text);
        // With a tail, only where it stood before is there surely room for it.
        let kept = match (&result, self.tail.is_empty()) {
            (Ok(()), _) => lines.len(),
            (Err(_), true) => {
                lines[..written].iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1)
            }
            (Err(_), false) => 0,
        };
        self.whole = Some(whole + kept as u64);
        self.lines += count(&lines[..kept]);
        if result.is_err() {
            self.failed = true;
            // The error before these is the one to tell.
            let _ = self.cut();
        }
        result
    }

    /// Ends the file after its last whole line.
    fn cut(&mut self) -> io::Result<()> {
        let whole = self.whole.unwrap_or(0);
        self.file.seek(SeekFrom::Start(whole))?;
        self.file.write_all(self.tail.as_bytes())?;
        self.file.set_len(whole + self.tail.len() as u64)
    }
}

fn count(lines: &[u8]) -> usize {
    lines.iter().filter(|&&byte| byte == b'\n').count()
}

/// Bytes written from a place in the file on, page by page, and the error that ended it.
fn write_counted(file: &mut File, place: u64, bytes: &[u8]) -> (usize, io::Result<()>) {
    let mut written = 0;
    while written < bytes.len() {
        let page = (PAGE - (place + written as u64) % PAGE) as usize;
        match file.write(&bytes[written..bytes.len().min(written + page)]) {
            Ok(0) => return (written, Err(io::ErrorKind::WriteZero.into())),
            Ok(more) => written += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return (written, Err(error)),
        }
    }
    (written, Ok(()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_whole_after_every_write() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pvd");
        let read = || std::fs::read_to_string(&path).unwrap();
        let mut text = GrowingFile::begin(File::create(&path).unwrap(), true, "<a>\n", "</a>\n").unwrap();
        assert_eq!((read().as_str(), text.lines()), ("<a>\n</a>\n", 0));
        text.add("<b/>\n").unwrap();
        text.finish().unwrap();
        assert_eq!((read().as_str(), text.lines()), ("<a>\n<b/>\n</a>\n", 1));
        text.add("<c/>\n").unwrap();
        text.finish().unwrap();
        assert_eq!((read().as_str(), text.lines()), ("<a>\n<b/>\n<c/>\n</a>\n", 2));
    }

    #[test]
    fn lines_that_wait_take_little_memory() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut text = GrowingFile::begin(File::create(&path).unwrap(), true, "head\n", "").unwrap();
        let line = "x".repeat(99) + "\n";
        for _ in 0..10_000 {
            text.add(&line).unwrap();
            assert!(text.waiting.len() <= ROOM + line.len());
        }
        text.finish().unwrap();
        assert_eq!(text.lines(), 10_000);
        assert_eq!(std::fs::metadata(&path).unwrap().len(), 5 + 1_000_000);
    }

    #[test]
    fn no_line_lies_on_two_pages() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut text =
            GrowingFile::begin(File::create(&path).unwrap(), true, "head of the table\n", "").unwrap();
        for i in 0..3_000 {
            text.add(&format!("{i},{:.9e}\n", -1.0 / (1.0 + f64::from(i)))).unwrap();
            if i % 100 == 0 {
                text.flush().unwrap();
            }
        }
        text.finish().unwrap();
        let written = std::fs::read(&path).unwrap();
        for page in written.chunks(PAGE as usize) {
            assert_eq!(page.last(), Some(&b'\n'), "whatever was killed between two pages left whole lines");
        }
        let rows = String::from_utf8(written).unwrap();
        for (row, i) in rows.lines().skip(1).zip(0..3_000) {
            let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            let value: f64 = format!("{:.9e}", -1.0 / (1.0 + f64::from(i))).parse().unwrap();
            assert_eq!(cells, [f64::from(i), value], "zeros at the end change nothing");
        }
        assert_eq!(rows.lines().count(), 3_001);
    }
}
