// How the tests of pages start Chromium: without connections of its own, rendering in software.

import { chromium } from 'playwright-core';

const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
const quiet = ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync'];
// Only WebGL is drawn by SwiftShader: it takes half as long again to draw the rest of the page, too.
const softwareGl = ['--disable-gpu-compositing', '--enable-unsafe-swiftshader', '--use-gl=angle', '--use-angle=swiftshader'];
const noGl = ['--disable-gpu', '--disable-3d-apis'];

export const launch = ({ webgl = true } = {}) =>
  chromium.launch({ executablePath, args: [...quiet, ...(webgl ? softwareGl : noGl)] });
