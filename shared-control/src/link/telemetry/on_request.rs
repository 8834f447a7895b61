//! Files and logs, which are sent with what the line has left.

use super::Telemetry;
use crate::link::file_transfer::FileRequest;
use crate::link::log_download::{LogRequest, LogStore};
use crate::link::spare_room::SpareRoom;
use crate::link::vehicle_status::VehicleStatus;

impl Telemetry {
    /// Takes what somebody demands of the files.
    pub fn take_file_request(&mut self, request: &FileRequest) {
        self.files.take(request);
    }

    /// Takes what the ground demands of the logs.
    pub fn take_log_request(&mut self, request: &LogRequest, store: &mut impl LogStore) {
        self.logs.take(request, store);
    }

    /// Writes of files and logs what the line has room for, after [`Self::poll`] and behind what that wrote into `out`.
    pub fn send_files<const N: usize>(
        &mut self,
        time_us: u64,
        status: &VehicleStatus,
        logs: &mut impl LogStore,
        out: &mut heapless::Vec<u8, N>,
    ) {
        self.room.pass_time(time_us, out.len());
        self.room = self.write_files((time_us, status), logs, self.room, out);
    }

    /// The same for a port that takes as much as fits into `out`.
    pub fn fill_with_files<const N: usize>(
        &mut self,
        time_us: u64,
        status: &VehicleStatus,
        logs: &mut impl LogStore,
        out: &mut heapless::Vec<u8, N>,
    ) {
        self.write_files((time_us, status), logs, SpareRoom::endless(), out);
    }

    /// Gives what is left of the room.
    fn write_files<const N: usize>(
        &mut self,
        (time_us, status): (u64, &VehicleStatus),
        logs: &mut impl LogStore,
        mut room: SpareRoom,
        out: &mut heapless::Vec<u8, N>,
    ) -> SpareRoom {
        if status.arming.is_armed() {
            self.logs.stop();
        }
        self.files.write(&mut self.writer, time_us, &mut room, out);
        self.logs.write(&mut self.writer, logs, &mut room, out);
        room
    }
}
