// DDS Security with the files and the environment of ROS 2: who has a certificate of the same authority feels the scene, who has none sees nothing.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { ddsType } from './messages.mjs';
import { Driver, Peer, Program, environment, eventually, makeFolder, makeWall, wait } from './program.mjs';

const kWrench = ddsType('geometry_msgs/WrenchStamped');
const kDomains = '<domains><id_range><min>0</min><max>230</max></id_range></domains>';
const kHead = '<?xml version="1.0" encoding="utf-8"?>\n<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">';

/** All is encrypted, nobody comes in without a certificate. */
const kGovernance = `${kHead}<domain_access_rules><domain_rule>${kDomains}
<allow_unauthenticated_participants>false</allow_unauthenticated_participants><enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind><liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>SIGN</rtps_protection_kind><topic_access_rules><topic_rule><topic_expression>*</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection><enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control><enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>ENCRYPT</metadata_protection_kind><data_protection_kind>ENCRYPT</data_protection_kind>
</topic_rule></topic_access_rules></domain_rule></domain_access_rules></dds>`;

/** \param topics that the one of this name may write; it may read all */
const permissionsOf = (name, topics) => `${kHead}<permissions><grant name="${name}"><subject_name>CN=${name}</subject_name>
<validity><not_before>2020-01-01T00:00:00</not_before><not_after>2035-01-01T00:00:00</not_after></validity>
<allow_rule>${kDomains}<publish><topics>${topics.map((topic) => `<topic>${topic}</topic>`).join('')}</topics></publish>
<subscribe><topics><topic>*</topic></topics></subscribe></allow_rule><default>DENY</default></grant></permissions></dds>`;

/** A keystore as `ros2 security create_keystore` and `create_enclave` make one. */
class Keystore {
  constructor(folder) {
    this.folder = folder;
    this.authority = this.#identity(folder, 'authority', ['-x509', '-days', '30']);
  }
  #openssl(...args) { execFileSync('openssl', args, { stdio: ['ignore', 'ignore', 'pipe'] }); }
  #identity(folder, name, how) {
    const key = join(folder, `${name}.key`);
    const out = join(folder, `${name}.pem`);
    this.#openssl('ecparam', '-name', 'prime256v1', '-genkey', '-noout', '-out', key);
    this.#openssl('req', '-new', ...how, '-key', key, '-subj', `/CN=${name}`, '-out', out);
    return { key, out };
  }
  #sign(text, out) {
    writeFileSync(`${out}.xml`, text);
    this.#openssl('smime', '-sign', '-text', '-in', `${out}.xml`, '-out', out, '-signer', this.authority.out, '-inkey', this.authority.key);
  }
  /** \returns its folder */
  enclave(name, topics = ['*']) {
    const folder = join(this.folder, 'enclaves', name);
    mkdirSync(folder, { recursive: true });
    const request = this.#identity(folder, name, []);
    this.#openssl('x509', '-req', '-in', request.out, '-CA', this.authority.out, '-CAkey', this.authority.key, '-CAcreateserial',
      '-days', '30', '-out', join(folder, 'cert.pem'));
    copyFileSync(request.key, join(folder, 'key.pem'));
    for (const ca of ['identity_ca', 'permissions_ca']) copyFileSync(this.authority.out, join(folder, `${ca}.cert.pem`));
    this.#sign(kGovernance, join(folder, 'governance.p7s'));
    this.#sign(permissionsOf(name, topics), join(folder, 'permissions.p7s'));
    return folder;
  }
}

describe('a domain that is secured', () => {
  let keystore;
  let node;
  let driver;
  const start = () => new Program(process.env.PALPATE_ROS2, '--ros-args', '-p', `scene:=${makeWall(makeFolder()).path}`,
    '-p', 'no_index_file:=true', '-p', 'tool:=[0.02, 0.02, 0.02]', '-p', 'device:=/omni,force_max=8,rate=20', '-p', 'device_frame:=base', '--enclave', '/palpate');

  before(() => {
    keystore = new Keystore(makeFolder());
    keystore.enclave('palpate');
    Object.assign(environment, { ROS_SECURITY_ENABLE: 'true', ROS_SECURITY_KEYSTORE: keystore.folder, ROS_SECURITY_STRATEGY: 'Enforce' });
    node = start();
    // Who greets first goes by the names. Where Fast DDS 2.9 does, Cyclone DDS 0.10 cannot read its key; by these, Cyclone does.
    driver = new Driver('/omni', 'reliable', true, keystore.enclave('device'));
  });
  after(async () => {
    await driver.kill();
    assert.equal(await node.end(), 0, node.said);
  });

  test('lets those feel who have a certificate, and shows nothing to who has none', async (context) => {
    await driver.lean();
    const stranger = new Peer();
    context.after(() => stranger.kill());
    stranger.tell(`reader force rt/omni/spatial/servo_cf ${kWrench} best_effort`);
    stranger.tell(`writer pose rt/omni/measured_cp ${ddsType('geometry_msgs/PoseStamped')} reliable`);
    await wait(3000);
    assert.deepEqual([await stranger.number('matched force'), await stranger.number('count force'), await stranger.number('matched pose')], [0, 0, 0]);
    await driver.lean(); // which is not disturbed
  });

  test('has the node do no more than its permissions say', async () => {
    keystore.enclave('narrow', ['rt/other']);
    environment.ROS_SECURITY_ENCLAVE_OVERRIDE = '/narrow';
    try {
      const refused = start();
      const [code] = await refused.ended;
      assert.equal(code, 1);
      assert.match(refused.said, /palpate_ros2: DDS: cannot .*(servo_cf|Not Allowed By Security).*/);
    } finally {
      delete environment.ROS_SECURITY_ENCLAVE_OVERRIDE;
    }
  });

  test('is not entered without the files, and not in silence where that is allowed', async () => {
    environment.ROS_SECURITY_ENCLAVE_OVERRIDE = '/nobody';
    try {
      const refused = start();
      const [code] = await refused.ended;
      assert.equal(code, 1);
      assert.match(refused.said, /^palpate_ros2: ROS_SECURITY_ENABLE: .*enclaves\/nobody\/identity_ca\.cert\.pem does not exist; .*\n$/);
      environment.ROS_SECURITY_STRATEGY = 'Permissive';
      const open = start();
      await open.says('NOT SECURED although ROS_SECURITY_ENABLE is true');
      await open.end();
    } finally {
      delete environment.ROS_SECURITY_ENCLAVE_OVERRIDE;
    }
  });
});
