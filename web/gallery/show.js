// The file that the page's own address names: /view/NAME.ldp.
const file = location.pathname.slice('/view/'.length);
document.title = decodeURIComponent(file);
document.querySelector('layered-panorama').setAttribute('src', `/panoramas/${file}`);
