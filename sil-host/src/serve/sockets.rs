//! Where ground stations connect: a UDP port that speaks first, as a vehicle's does, and a TCP server.
//!
//! All of them share the vehicle's one link, as behind a radio: each hears everything that it says, and what each sends
//! is taken apart by a receiver of its own, so that nobody's halves of messages meet.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};

use shared_control::link::{LinkSettings, Receiver};

use super::SimulatedBoard;

/// Largest datagram that is taken.
const DATAGRAM_MAX: usize = 2048;
/// Others than the first who are heard over UDP; the one silent for longest makes room.
const PEERS_MAX: usize = 8;
/// TCP clients at once; more are turned away.
const CLIENTS_MAX: usize = 8;
/// What one client may send between two looks: more waits in its socket.
const READS_PER_LOOK: usize = 4;

/// What is opened.
#[derive(Clone, Copy, Debug, Default)]
pub struct SocketsSetup {
    /// A ground station to which everything is sent over UDP, heard from or not.
    pub udp: Option<SocketAddr>,
    /// Where TCP clients are waited for.
    pub tcp: Option<SocketAddr>,
}

/// One at the other end.
struct Peer<S> {
    stream: S,
    address: SocketAddr,
    receiver: Receiver,
}

/// The open sockets.
pub struct Sockets {
    settings: LinkSettings,
    udp: Option<UdpSocket>,
    /// Who is sent to: the first always, the others since they spoke, the latest last.
    udp_peers: Vec<Peer<()>>,
    listener: Option<TcpListener>,
    clients: Vec<Peer<TcpStream>>,
    news: Vec<String>,
    /// Bytes that came.
    pub bytes_received: u64,
    /// Bytes that the vehicle has said, however many heard them.
    pub bytes_sent: u64,
}

impl Sockets {
    /// Opens them.
    ///
    /// # Errors
    /// The operating system's, with the address.
    pub fn open(setup: &SocketsSetup, settings: LinkSettings) -> io::Result<Self> {
        let named = |address: SocketAddr| {
            move |error: io::Error| io::Error::new(error.kind(), format!("{address}: cannot be opened: {error}"))
        };
        let udp = setup.udp.map(|ground| {
            // to a ground on this machine from this machine alone, else from wherever it is reached
            let own = if ground.ip().is_loopback() { ground.ip() } else { unspecified(ground) };
            let socket = UdpSocket::bind((own, 0)).and_then(|socket| socket.set_nonblocking(true).map(|()| socket));
            socket.map_err(named(ground))
        });
        let listener = setup.tcp.map(|address| {
            let listener = TcpListener::bind(address).and_then(|tcp| tcp.set_nonblocking(true).map(|()| tcp));
            listener.map_err(named(address))
        });
        let first = setup.udp.map(|address| Peer { stream: (), address, receiver: Receiver::new(settings) });
        Ok(Self {
            settings,
            udp: udp.transpose()?,
            udp_peers: first.into_iter().collect(),
            listener: listener.transpose()?,
            clients: Vec::new(),
            news: Vec::new(),
            bytes_received: 0,
            bytes_sent: 0,
        })
    }

    /// Where TCP clients connect: the port that was chosen, where any was to be.
    pub fn tcp_address(&self) -> Option<SocketAddr> {
        self.listener.as_ref()?.local_addr().ok()
    }

    /// Who came and went, in words, since the last time.
    pub fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }

    /// Takes what has arrived and lets the board hear it.
    pub fn receive(&mut self, board: &mut SimulatedBoard) {
        self.accept();
        self.receive_udp(board);
        let (mut buffer, mut received) = ([0; DATAGRAM_MAX], 0);
        let news = &mut self.news;
        self.clients.retain_mut(|client| {
            for _ in 0..READS_PER_LOOK {
                match client.stream.read(&mut buffer) {
                    Ok(0) => {
                        news.push(format!("TCP  {} has left", client.address));
                        return false;
                    }
                    Ok(length) => {
                        received += length as u64;
                        hear(board, &mut client.receiver, client.address, &buffer[..length]);
                    }
                    Err(error) if is_nothing_yet(&error) => break,
                    Err(error) => {
                        news.push(format!("TCP  {} is lost: {error}", client.address));
                        return false;
                    }
                }
            }
            true
        });
        self.bytes_received += received;
    }

    /// Says it to all. A TCP client that does not read what it is sent is left out of it.
    pub fn send(&mut self, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        self.bytes_sent += bytes.len() as u64;
        if let Some(udp) = &self.udp {
            for peer in &self.udp_peers {
                // nobody may be there yet: it is said again
                let _ = udp.send_to(bytes, peer.address);
            }
        }
        let news = &mut self.news;
        self.clients.retain_mut(|client| match client.stream.write_all(bytes) {
            Ok(()) => true,
            Err(error) => {
                news.push(format!("TCP  {} is dropped: {error}", client.address));
                false
            }
        });
    }

    fn accept(&mut self) {
        let Some(listener) = &self.listener else { return };
        while let Ok((stream, address)) = listener.accept() {
            let ready = stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true));
            if ready.is_ok() && self.clients.len() < CLIENTS_MAX {
                self.news.push(format!("TCP  {address} is here"));
                self.clients.push(Peer { stream, address, receiver: Receiver::new(self.settings) });
            } else {
                self.news.push(format!("TCP  {address} is turned away: {CLIENTS_MAX} are here"));
            }
        }
    }

    fn receive_udp(&mut self, board: &mut SimulatedBoard) {
        let Some(udp) = &self.udp else { return };
        let mut buffer = [0; DATAGRAM_MAX];
        for _ in 0..READS_PER_LOOK * PEERS_MAX {
            // an error is one peer's port being closed: nothing to do with the next datagram
            let Ok((length, from)) = udp.recv_from(&mut buffer) else { break };
            self.bytes_received += length as u64;
            let known = self.udp_peers.iter().position(|peer| peer.address == from);
            let at = known.unwrap_or_else(|| {
                self.news.push(format!("UDP  {from} speaks"));
                if self.udp_peers.len() > PEERS_MAX {
                    self.udp_peers.remove(1);
                }
                self.udp_peers.push(Peer { stream: (), address: from, receiver: Receiver::new(self.settings) });
                self.udp_peers.len() - 1
            });
            hear(board, &mut self.udp_peers[at].receiver, from, &buffer[..length]);
            if at > 0 {
                // the latest last, but for the first
                self.udp_peers[at..].rotate_left(1);
            }
        }
    }
}

fn unspecified(like: SocketAddr) -> std::net::IpAddr {
    if like.is_ipv4() { std::net::Ipv4Addr::UNSPECIFIED.into() } else { std::net::Ipv6Addr::UNSPECIFIED.into() }
}

fn hear(board: &mut SimulatedBoard, receiver: &mut Receiver, from: SocketAddr, bytes: &[u8]) {
    bytes.iter().for_each(|byte| board.hear(receiver, *byte, from.ip().is_loopback()));
}

fn is_nothing_yet(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
