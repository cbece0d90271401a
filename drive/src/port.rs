//! The line: a serial device, a pseudo terminal or TCP.

use crate::DriveError;
use std::io::{Error, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Speed of the firmware's serial line (baud).
pub const BAUD: u32 = 921_600;

/// Longest wait for bytes: how soon a key is seen.
const TIMEOUT: Duration = Duration::from_millis(10);

/// Between two attempts to connect.
const PAUSE: Duration = Duration::from_millis(50);

/// Bytes both ways; a read without bytes ends with [`ErrorKind::TimedOut`] or [`ErrorKind::WouldBlock`] within 10 ms.
pub trait Line: Read + Write + Send {}

impl<T: Read + Write + Send> Line for T {}

/// Opens `tcp:HOST:PORT`, or a serial device by its path, at `baud`. A connection that is refused is tried again for `wait`.
///
/// # Errors
/// [`DriveError::Open`].
pub fn open(port: &str, baud: u32, wait: Duration) -> Result<Box<dyn Line>, DriveError> {
    let start = Instant::now();
    loop {
        let opened = match port.strip_prefix("tcp:") {
            Some(address) => tcp(address),
            None => serial(port, baud),
        };
        match opened {
            Ok(line) => return Ok(line),
            Err(error)
                if start.elapsed() < wait
                    && matches!(
                        error.kind(),
                        ErrorKind::ConnectionRefused | ErrorKind::NotFound
                    ) =>
            {
                std::thread::sleep(PAUSE);
            }
            Err(error) => {
                return Err(DriveError::Open {
                    port: port.to_owned(),
                    error,
                });
            }
        }
    }
}

fn tcp(address: &str) -> Result<Box<dyn Line>, Error> {
    let stream = TcpStream::connect(address)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(TIMEOUT))?;
    Ok(Box::new(stream))
}

fn serial(path: &str, baud: u32) -> Result<Box<dyn Line>, Error> {
    // Its own message for a missing file is that of the system.
    if std::fs::metadata(path)?.is_file() {
        // The system's message would be of a typewriter.
        return Err(Error::other("it is a file, not a serial port"));
    }
    let port = serialport::new(path, baud).timeout(TIMEOUT).open()?;
    Ok(Box::new(port))
}
