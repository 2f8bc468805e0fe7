//! The members of a group.
//!
//! `hdf5_reader::Group::members` fails as a whole when one member is of a kind that it does not read; the
//! names and addresses here let each member fail by itself.

use hdf5_reader::error::Result;
use hdf5_reader::fractal_heap::{FractalHeap, FractalHeapDirectBlockCache};
use hdf5_reader::io::Cursor;
use hdf5_reader::local_heap::LocalHeap;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::link::{self, LinkMessage, LinkTarget};
use hdf5_reader::messages::link_info::LinkInfoMessage;
use hdf5_reader::messages::symbol_table_msg::SymbolTableMessage;
use hdf5_reader::object_header::ObjectHeader;
use hdf5_reader::symbol_table::SymbolTableNode;
use hdf5_reader::{Hdf5File, btree_v1, btree_v2};

/// A name in a group.
pub(super) struct Link {
    pub(super) name: String,
    pub(super) target: Target,
    /// When it was made, if the group keeps count.
    made: Option<u64>,
}

/// What a name stands for.
pub(super) enum Target {
    /// The object with this header.
    Object(u64),
    /// Something in another file.
    File(String),
}

/// The members of the group with this header, in the order in which they were made if that is known, by
/// name otherwise. Soft links are left out: what they lead to has a name of its own.
pub(super) fn read(file: &Hdf5File, header: &ObjectHeader) -> Result<Vec<Link>> {
    let mut links = Vec::new();
    for message in &header.messages {
        match message {
            HdfMessage::SymbolTable(table) => read_table(file, table, &mut links)?,
            HdfMessage::Link(link) => links.extend(known(link.clone())),
            HdfMessage::LinkInfo(info) => read_heap(file, info, &mut links)?,
            _ => {}
        }
    }
    if links.iter().all(|link| link.made.is_some()) {
        links.sort_by_key(|link| link.made);
    } else {
        links.sort_by(|a, b| a.name.cmp(&b.name));
    }
    Ok(links)
}

fn known(link: LinkMessage) -> Option<Link> {
    let target = match link.target {
        LinkTarget::Hard { address } => Target::Object(address),
        LinkTarget::External { filename, .. } => Target::File(filename),
        LinkTarget::Soft { .. } => return None,
    };
    Some(Link {
        name: link.name,
        target,
        made: link.creation_order,
    })
}

fn read_table(file: &Hdf5File, table: &SymbolTableMessage, links: &mut Vec<Link>) -> Result<()> {
    let (offset_size, length_size) = sizes(file);
    let storage = file.storage();
    let heap = LocalHeap::parse_at_storage(storage, table.heap_address, offset_size, length_size)?;
    let leaves = btree_v1::collect_btree_v1_leaves_storage(
        storage,
        table.btree_address,
        offset_size,
        length_size,
        None,
        &[],
        None,
    )?;
    for (_, address) in leaves {
        let head = storage.read_range(address, 8)?;
        let symbols = usize::from(u16::from_le_bytes([head[6], head[7]]));
        let len = 8 + symbols * (2 * usize::from(offset_size) + 24);
        let node = storage.read_range(address, len)?;
        let node = SymbolTableNode::parse(&mut Cursor::new(&node), offset_size, length_size)?;
        for entry in node.entries {
            // The others are soft links.
            if entry.cache_type != 2 {
                links.push(Link {
                    name: heap.get_string_storage(entry.link_name_offset, storage)?,
                    target: Target::Object(entry.object_header_address),
                    made: None,
                });
            }
        }
    }
    Ok(())
}

fn read_heap(file: &Hdf5File, info: &LinkInfoMessage, links: &mut Vec<Link>) -> Result<()> {
    let (offset_size, length_size) = sizes(file);
    if Cursor::is_undefined_offset(info.fractal_heap_address, offset_size) {
        return Ok(());
    }
    let storage = file.storage();
    let address = info.fractal_heap_address;
    let heap = FractalHeap::parse_at_storage(storage, address, offset_size, length_size)?;
    let address = info.btree_name_index_address;
    let tree =
        btree_v2::BTreeV2Header::parse_at_storage(storage, address, offset_size, length_size)?;
    let records = btree_v2::collect_btree_v2_records_storage(
        storage,
        &tree,
        offset_size,
        length_size,
        None,
        &[],
        None,
    )?;
    let mut cache = FractalHeapDirectBlockCache::default();
    for record in &records {
        let btree_v2::BTreeV2Record::LinkNameHash { heap_id, .. } = record else {
            continue;
        };
        let bytes =
            heap.get_object_storage_cached(heap_id, storage, offset_size, length_size, &mut cache)?;
        let message = link::parse(
            &mut Cursor::new(&bytes),
            offset_size,
            length_size,
            bytes.len(),
        )?;
        links.extend(known(message));
    }
    Ok(())
}

fn sizes(file: &Hdf5File) -> (u8, u8) {
    let superblock = file.superblock();
    (superblock.offset_size, superblock.length_size)
}
