// Messages of ROS 2 as bytes, by their own definitions and a serializer that is none of Palpate's.
import common from '@foxglove/rosmsg-msgs-common';
import { parse } from '@foxglove/rosmsg';
import { MessageReader, MessageWriter } from '@foxglove/rosmsg2-serialization';
import { createHash } from 'node:crypto';

const known = common.ros2jazzy;

/** The definition of a message and of all that it is made of, itself first and without a name. */
function definitionsOf(name) {
  const found = new Map();
  const add = (type) => {
    if (found.has(type)) return;
    if (!known[type]) throw new Error(`no message ${type}`);
    found.set(type, known[type]);
    for (const field of known[type].definitions) if (field.isComplex) add(field.type);
  };
  add(name);
  return [...found].map(([type, { definitions }]) => (type === name ? { definitions } : { name: type, definitions }));
}

/** "geometry_msgs/PoseStamped", or the text of a definition. */
const definitions = (type) => (/^\w+\/\w+$/.test(type) ? definitionsOf(type) : parse(type, { ros2: true }));

export const encode = (type, message) => Buffer.from(new MessageWriter(definitions(type)).writeMessage(message)).toString('hex');
export const decode = (type, hex) => new MessageReader(definitions(type)).readMessage(new Uint8Array(Buffer.from(hex, 'hex')));

/** As DDS names a type. */
export const ddsType = (type) => type.replace('/', '::msg::dds_::') + '_';

// REP 2016, the hash of a type's description.
const kIds = { int8: 2, uint8: 3, int16: 4, uint16: 5, int32: 6, uint32: 7, int64: 8, uint64: 9, float32: 10, float64: 11, bool: 15, string: 17 };
const kByte = 16;
const kBytes = new Set(['diagnostic_msgs/msg/DiagnosticStatus.level']); // "byte", which the definitions here call uint8
const kArray = 48;
const kSequence = 144;
const kTimes = { time: 'builtin_interfaces/msg/Time', duration: 'builtin_interfaces/msg/Duration' };

const fullName = (type) => kTimes[type] ?? type.replace('/', '/msg/');
const described = (name, id, nested = '', capacity = 0) =>
  ({ name, type: { type_id: id, capacity, string_capacity: 0, nested_type_name: nested } });

function describe(type) {
  if (type in kTimes) return { type_name: kTimes[type], fields: [described('sec', kIds.int32), described('nanosec', kIds.uint32)] };
  const fields = known[type].definitions.filter((field) => !field.isConstant).map((field) => {
    const nested = field.isComplex || field.type in kTimes ? fullName(field.type) : '';
    let id = nested ? 1 : kIds[field.type];
    if (kBytes.has(`${fullName(type)}.${field.name}`)) id = kByte;
    if (field.isArray) id += field.arrayLength ? kArray : kSequence;
    return described(field.name, id, nested, field.arrayLength ?? 0);
  });
  return { type_name: fullName(type), fields };
}

/** JSON as Python writes it, whose bytes are hashed. */
function pythonJson(value) {
  if (Array.isArray(value)) return `[${value.map(pythonJson).join(', ')}]`;
  if (typeof value !== 'object') return JSON.stringify(value);
  return `{${Object.entries(value).map(([key, item]) => `${JSON.stringify(key)}: ${pythonJson(item)}`).join(', ')}}`;
}

export function typeHash(type) {
  const all = new Map();
  const add = (name) => {
    if (all.has(fullName(name))) return;
    all.set(fullName(name), describe(name));
    for (const field of known[name]?.definitions ?? []) {
      if (field.isComplex || field.type in kTimes) add(field.type);
    }
  };
  add(type);
  const main = all.get(fullName(type));
  all.delete(fullName(type));
  const others = [...all.keys()].sort().map((name) => all.get(name));
  return createHash('sha256').update(pythonJson({ type_description: main, referenced_type_descriptions: others })).digest('hex');
}
