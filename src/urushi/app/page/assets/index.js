var e,t,n,r,i,a,o,s,c,l,u,d=Symbol.for(`pv`),f={},p=[],m=/^m(i|n|o|s|text|space)$/,h=Array.isArray,g=p.slice,_=Object.assign;function v(e){e&&e.parentNode&&e.remove()}function y(e,t,n){var r,i,a,o={},s=arguments.length;for(a in t)a==`key`?r=t[a]:a==`ref`&&typeof e!=`function`?i=t[a]:o[a]=t[a];return s>2&&(o.children=s>3?g.call(arguments,2):n),b(e,o,r,i,null)}function b(n,r,i,a,o){var s={type:n,props:r,key:i,ref:a,__k:null,__:null,__b:0,__e:null,__c:null,constructor:d,__v:o||++t,__i:-1,__u:0};return!o&&e.vnode&&e.vnode(s),s}function x(e){return e.children}function S(e,t){this.props=e,this.context=t,this.__g=0}function C(e,t){if(t==null)return e.__&&C(e.__,e.__i+1);for(var n;t<e.__k.length;t++)if((n=e.__k[t])&&n.__e)return n.__e;return typeof e.type!=`function`||e.props.__P?null:C(e)}function w(t){var n,r=t.__v,i=r.__e,a=[],o=[],s=t.__P;s&&((n=_({constructor:d},r)).__v=r.__v+1,e.vnode&&e.vnode(n),re(s,n,r,t.__n,s.namespaceURI,32&r.__u?[i]:null,a,i||C(r),32&r.__u,o),n.__v=r.__v,n.__.__k[n.__i]=n,oe(a,n,o),r.__=r.__e=null,n.__e!=i&&T(n))}function T(e){if((e=e.__)&&e.__c&&!e.props.__P)return e.__e=null,e.__k.some(function(t){return t&&(e.__e=t.__e)}),T(e)}function E(t){(8&t.__g||(t.__g|=8,r.push(t),a++))&&i==e.debounceRendering||((i=e.debounceRendering)||queueMicrotask)(D)}function D(){try{for(var e,t=1;r.length;)r.length>t&&r.sort(o),e=r.shift(),t=r.length,8&e.__g&&w(e)}finally{(a=r.length)&&(i||queueMicrotask)(D)}}function ee(e,t,n,r,i,a,o,s,c,l,u){var d,m,h,g,_,v,y=r.__k||p,b=t.length;for(c=te(n,t,y,c,b),d=0;d<b;d++)(h=n.__k[d])!=null&&(m=~h.__i&&y[h.__i]||f,h.__i=d,v=re(e,h,m,i,a,o,s,c,l,u),g=h.__e,(m.ref!=h.ref||8&m.__u)&&(m.ref&&M(m.ref,null,h,m),h.ref&&u.push(h.ref,h.__c||g,h)),_||=g,4&h.__u?(c=O(h,c,e,!m.__v),m.__e&&(m.__e=null)):typeof h.type==`function`&&v!==void 0?c=v:g&&(c=g.nextSibling),h.__u&=-21);return n.__e=_,c}function te(e,t,n,r,i){var a,o,s,c,l,u,f,p,m,g=n.length,_=g,v=0,y=0,S=e.__k=Array(i);for(a=0;a<i;a++)(o=t[a])!=null&&typeof o!=`boolean`&&typeof o!=`function`?(typeof o!=`object`||o.constructor===String?o=S[a]=b(null,o):h(o)?o=S[a]=b(x,{children:o}):o.constructor===d&&o.__b?o=S[a]=b(o.type,o.props,o.key,o.ref,o.__v):S[a]=o,c=a+v,o.__=e,o.__b=e.__b+1,s=null,~(l=o.__i=k(o,n,c,_))&&(_--,(s=n[l])&&(s.__u|=2)),s&&s.__v?(o.__u|=16,l==c-1?v--:l==c+1?v++:l!=c&&(l>c?v--:v++,y=1)):(~l||(i>g?v--:i<g&&v++),typeof o.type!=`function`&&(o.__u|=4))):S[a]=null;if(y){for(u=[],f=[],a=0;a<i;a++)if((o=S[a])&&16&o.__u){for(v=0,p=u.length;v<p;)u[m=v+p>>1]<o.__i?v=m+1:p=m;u[v]=o.__i,f[a]=v+1}for(v=u.length;a--;)f[a]&&(f[a]==v?v--:S[a].__u|=4)}if(_)for(a=0;a<g;a++)!(s=n[a])||2&s.__u||(s.__e==r&&(r=C(s)),N(s,s));return r}function O(e,t,n,r){var i,a,o,s;if(typeof e.type==`function`){if(e.props.__P)return t;if(i=e.__k)for(a=0;a<i.length;a++)i[a]&&(i[a].__=e,t=O(i[a],t,n,!1));return t}for(t&&!t.parentNode&&(t=C(e))&&!t.parentNode&&(t=null),o=e.__e,s=t;s&&s.nodeType==8;)s=s.nextSibling;for(o!=s&&(!r&&n.moveBefore&&o.parentNode?n.moveBefore(o,t):n.insertBefore(o,t||null)),t=o;(t&&=t.nextSibling)&&t.nodeType==8&&!t.data.startsWith(`$s`););return t}function k(e,t,n,r){var i,a=e.key,o=e.type,s=t[n],c=s&&!(2&s.__u);if(s===null&&a==null||c&&a==s.key&&o==s.type)return n;if(r>+!!c){for(i=n-1;i>=0;i--)if((s=t[i])&&!(2&s.__u)&&a==s.key&&o==s.type)return i;for(i=n+1;i<t.length;i++)if((s=t[i])&&!(2&s.__u)&&a==s.key&&o==s.type)return i}return-1}function ne(e,t,n){n??=``,t[0]==`-`?e.setProperty(t,n):e[t]=n}function A(e,t,n,r,i){var a,o;if(t==`style`){if(typeof n==`string`)e.style.cssText=n;else{if(typeof r==`string`&&(e.style.cssText=r=``),r)for(t in r)n&&t in n||ne(e.style,t);if(n)for(t in n)r&&n[t]==r[t]||ne(e.style,t,n[t])}}else if(t[0]==`o`&&t[1]==`n`)typeof n!=`function`&&(n=null),typeof r!=`function`&&(r=null),(e.__e||={})[t]=n,n&&r||(o=u[t]||(u[t]=j(t)),(e.__a||={})[t]=l,a=t!=(t=t.replace(c,`$1`)),(t=t.slice(2))[0]<`a`&&(t=t.toLowerCase()),n?e.addEventListener(t,o,a):e.removeEventListener(t,o,a));else{if(i==`http://www.w3.org/2000/svg`)t=t.replace(/xlink(H|:h)/,`h`).replace(/sName$/,`s`);else if(t!=`width`&&t!=`height`&&t!=`href`&&t!=`list`&&t!=`form`&&t!=`tabIndex`&&t!=`download`&&t!=`rowSpan`&&t!=`colSpan`&&t!=`role`&&t!=`popover`&&t in e)try{e[t]=n??``;return}catch{}if(typeof n==`function`)return;n==null||!1===n&&t[4]!=`-`?e.removeAttribute(t):e.setAttribute(t,t==`popover`&&n==1?``:n)}}function j(t){return function(n){var r=this.__e;if(r){if(r=r[t],n[s]==null)n[s]=l++;else if(n[s]<this.__a[t])return;return r(e.event?e.event(n):n)}}}function re(t,n,r,i,a,o,s,c,l,u){var f,m,g,y,b,w,T,E,D,te,O,k,ne,A,j,re,oe,M,le=n.type;if(n.constructor!==d)return null;128&r.__u&&(l=32&r.__u,f=r.__c.__z)&&(n.__u|=l,m=o=[],f.nodeType==8?c=ie(f,o):o.push(f),c=o[0]||c),(f=e.__b)&&f(n);n:if(typeof le==`function`){g=s.length;try{if(E=n.props,D=(f=le.prototype)&&f.render,te=(f=le.contextType)&&i[f.__c],O=f?te?te.props.value:f.__:i,(y=r.__c)?(n.__c=y,2&y.__g&&(y.__g|=1)):(D?n.__c=y=new le(E,O):(n.__c=y=new S(E,O),y.constructor=le,y.render=ce),te&&te.sub(y),y.state||(y.state={}),y.__n=i,y.__g|=8,y.__h=[],y.__k=[]),D&&(y.__s||(y.__s=y.state),le.getDerivedStateFromProps&&(y.__s==y.state&&(y.__s=_({},y.__s)),_(y.__s,le.getDerivedStateFromProps(E,y.__s)))),b=y.props,w=y.state,y.__v=n,r.__c){if(E!==b&&D&&!le.getDerivedStateFromProps&&y.componentWillReceiveProps&&y.componentWillReceiveProps(E,O),n.__v==r.__v&&!(8&y.__g)||!(4&y.__g)&&y.shouldComponentUpdate&&!1===y.shouldComponentUpdate(E,y.__s,O)){n.__v!=r.__v&&(y.props=E,y.state=y.__s,y.__g&=-9),n.__e=r.__e,n.__k=r.__k,n.__k.some(function(e){e&&(e.__=n)}),p.push.apply(y.__h,y.__k),y.__k=[],y.__h.length&&s.push(y),c=C(r);break n}y.componentWillUpdate&&y.componentWillUpdate(E,y.__s,O),D&&y.componentDidUpdate&&y.__h.push(function(){y.componentDidUpdate(b,w,T)})}else D&&!le.getDerivedStateFromProps&&y.componentWillMount&&y.componentWillMount(),D&&y.componentDidMount&&y.__h.push(y.componentDidMount);y.context=O,y.props=E,y.__P=t,y.__g&=-5,k=e.__r,ne=D?25:0;do y.__g&=-9,k&&k(n),f=y.render(y.props,y.state=y.__s,y.context);while(8&y.__g&&++ne<25);D&&(p.push.apply(y.__h,y.__k),y.__k=[]),y.state=y.__s,y.getChildContext&&(i=_({},i,y.getChildContext())),D&&r.__c&&y.getSnapshotBeforeUpdate&&(T=y.getSnapshotBeforeUpdate(b,w)),A=f&&f.type===x&&f.key==null?f.props.children:f,E.__P&&(f=c,a=(t=E.__P).namespaceURI,l=o=null,r.props&&r.props.__P!=t&&(r.__k.some(function(e){e&&N(e,e)}),r.__k=null),c=r.__k?C(r,0):null),c=ee(t,h(A)?A:[A],n,r,i,a,o,s,c,l,u),E.__P&&(n.__e=null,c=f),n.__u&=-161,m&&m.some(v),y.__h.length&&s.push(y),1&y.__g&&(y.__g&=-4)}catch(t){if(s.length=g,n.__v=null,l||o){if(t&&t.then){if(n.__u|=128|l,o){for(~(oe=o.indexOf(c||void 0))||(oe=o.length);(M=o[oe-1])&&M.nodeType==8;)oe--;for(;oe<o.length;oe++)if(M=o[oe]){if(o[oe]=null,j){if(M==re)break}else{if(M.nodeType!=8)break;M.data.startsWith(`$s`)&&(re=ie(j=M))}}}if(!j){for(;c&&c.nodeType==8&&c.nextSibling;)c=c.nextSibling;j=c}(f=ie(j=n.__c.__z||(n.__c.__z=j)))?(n.__e=j,c=f):n.__e=c,c&&=c.nextSibling}else o&&o.some(v)}else n.__e=r.__e;n.__k||=r.__k||[],t&&t.then||ae(n),e.__e(t,n,r)}}else c=n.__e=se(r.__e,n,r,i,a,o,s,l,u,t);return(f=e.diffed)&&f(n),c}function ie(e,t){if(e&&e.nodeType==8&&e.data.startsWith(`$s`))for(var n=1;e=e.nextSibling;){if(e.nodeType==8){if(e.data.startsWith(`$s`))n++;else if(e.data.startsWith(`/$s`)&&!--n)return e}t&&t.push(e)}}function ae(e){e&&(e.__c&&(e.__c.__g|=4),e.__k&&e.__k.some(ae))}function oe(t,n,r){for(var i=0;i<r.length;)M(r[i++],r[i++],r[i++]);e.__c&&e.__c(n,t),t.some(function(n){try{t=n.__h,n.__h=[],t.some(function(e){e.call(n)})}catch(t){e.__e(t,n.__v)}})}function se(t,n,r,i,a,o,s,c,l,u){var d,p,_,y,b,x,S,w,T=r.props||f,E=n.props,D=n.type;if(D==`svg`?a=`http://www.w3.org/2000/svg`:D==`math`?a=`http://www.w3.org/1998/Math/MathML`:a||=`http://www.w3.org/1999/xhtml`,o){for(d=0;d<o.length;d++)if((b=o[d])&&(D?b.localName==D:b.nodeType==3)){t=b,o[d]=null;break}}if(!t){if(w=u.ownerDocument||document,!D)return w.createTextNode(E);t=w.createElementNS(a,D,E.is?E:u),c&&=(e.__m&&e.__m(n,o),!1),o=null}if(D){if(u=D==`template`&&t.content||t,o=D==`textarea`&&E.defaultValue!=null?null:o&&g.call(u.childNodes),!c&&o)for(T={},d=0;d<t.attributes.length;d++)T[(b=t.attributes[d]).name]=b.value;for(d in T)b=T[d],d==`dangerouslySetInnerHTML`?_=b:d==`children`||d in E||d==`value`&&`defaultValue`in E||d==`checked`&&`defaultChecked`in E||A(t,d,null,b,a);for(d in E)b=E[d],d==`children`?y=b:d==`dangerouslySetInnerHTML`?p=b:d==`value`?x=b:d==`checked`?S=b:c&&typeof b!=`function`||T[d]===b||A(t,d,b,T[d],a);p?(c||_&&(p.__html==_.__html||p.__html==t.innerHTML)||(t.innerHTML=p.__html),n.__k=[]):(_&&(t.textContent=``),(D==`foreignObject`||a==`http://www.w3.org/1998/Math/MathML`&&m.test(D))&&(a=`http://www.w3.org/1999/xhtml`),ee(u,h(y)?y:[y],n,r,i,a,o,s,o?o[0]:r.__k&&C(r,0),c,l),o&&o.some(v)),c&&D!=`textarea`||(d=`value`,D==`progress`&&x==null?t.removeAttribute(d):x==null||x===t[d]&&(D!=`progress`||x)||A(t,d,x,T[d],a),d=`checked`,S!=null&&S!=t[d]&&A(t,d,S,T[d],a))}else T===E||c&&t.data==E||(t.data=E);return t}function M(t,n,r,i){try{typeof t==`function`?n?n.__x=t(n)||1:(i&&=i.__c||i.__e)&&(n=i.__x)&&(i.__x=null,typeof n==`function`?n():t(null)):t.current=n}catch(t){e.__e(t,r)}}function N(t,n,r){var i,a,o,s;if(e.unmount&&e.unmount(t),!(i=t.ref)||i.current&&i.current!=t.__e||M(i,null,n,t),i=t.__c){if(i.componentWillUnmount)try{i.componentWillUnmount()}catch(t){e.__e(t,n)}i.__P=i.__n=null}if(i=t.__k)for(s=0;s<i.length;s++)i[s]&&N(i[s],n,typeof t.type!=`function`||r&&!t.props.__P);!r&&(i=t.__c)&&(i=i.__z)&&(a=ie(i,o=[]))&&(i==t.__e&&o.some(v),v(a),v(i)),r||v(t.__e),t.__e=t.__c=t.__=null}function ce(e,t,n){return this.constructor(e,n)}function le(t,n){var r,i,a,o;e.__&&e.__(t,n),n.nodeType==9&&(n=n.documentElement),i=(r=t&&32&t.__u)?null:n.__k,n.__k=b(x,{children:[t]}),a=[],o=[],re(n,n.__k,i||f,f,n.namespaceURI,i?null:n.firstChild?g.call(n.childNodes):null,a,i?i.__e:n.firstChild,r,o),oe(a,n.__k,o),n.__k.props.children=null}e={__e:function(e,t,n,r){for(var i,o,s;t=t.__;)if((i=t.__c)&&!(1&i.__g)){i.__g|=4;try{if((s=(o=i.constructor)&&o.getDerivedStateFromError)&&i.setState(o.getDerivedStateFromError(e)),i.componentDidCatch&&(i.componentDidCatch(e,r||{}),s=1),s&&8&i.__g)return void(i.__g|=2)}catch(t){e=t}}throw a=0,e}},t=0,n=function(e){return e!=null&&e.constructor===d},S.prototype.setState=function(e,t){var n=this.__s;n&&n!=this.state||(n=this.__s=_({},this.state)),typeof e==`function`&&(e=e(_({},n),this.props)),e&&(_(n,e),this.__v&&(t&&this.__k.push(t),E(this)))},S.prototype.forceUpdate=function(e){this.__v&&(this.__g|=4,e&&this.__h.push(e),E(this))},S.prototype.render=x,r=[],a=0,o=function(e,t){return e.__v.__b-t.__v.__b},s=Symbol(),c=/(PointerCapture)$|Capture$/i,l=0,u={};var ue,P,de,fe,pe=Object.is,me=0,he=[],ge=[],F=e,_e=F.__b,ve=F.__r,ye=F.diffed,be=F.__c,xe=F.unmount,Se=F.__;function Ce(e,t){F.__h&&F.__h(P,e,me||t),me=0;var n=P.__H||(P.__H={__:[],__h:[]});return e>=n.__.length&&n.__.push({}),n.__[e]}function we(e,t){var n=Ce(ue++,3);!F.__s&&Ne(n.__H,t)&&(n.__P=!0,n.__=e,n.u=t,P.__H.__h.push(n))}function Te(e){return me=5,Ee(function(){return{current:e}},[])}function Ee(e,t){var n=Ce(ue++,7);return Ne(n.__H,t)&&(n.__=e(),n.__H=t),n.__}function De(){var e;do{for(;e=ge.shift();)try{je(e)}catch(t){F.__e(t,{__:(e=e.__P)&&e.__v})}for(;e=he.shift();){var t=e.__H;if(e.__P&&t)try{t.__h.some(je),t.__h.some(Me),t.__h=[]}catch(n){t.__h=[],F.__e(n,e.__v)}}}while(ge.length)}F.__b=function(e){P=null,_e&&_e(e)},F.__=function(e,t){e&&t.__k&&t.__k.__m&&(e.__m=t.__k.__m),Se&&Se(e,t)},F.__r=function(e){ve&&ve(e),ue=0;var t=(P=e.__c).__H;t&&(de==P?P.__h=[]:(t.__h.some(je),t.__h.some(Me),ue=0),t.__h=[],t.__.some(function(e){e.__N&&(e.__=e.__N),e.u=e.__N=void 0})),de=P},F.diffed=function(e){ye&&ye(e);var t=e.__c;t&&t.__H&&(t.__H.__h.length&&Ae(he.push(t)),t.__H.__.some(function(e){e.u&&(e.__H=e.u)})),de=P=null},F.__c=function(e,t){t.some(function(e){try{e.__h.some(je),e.__h=e.__h.filter(function(e){return!e.__||Me(e)})}catch(t){e.__h=[function(){throw t}]}}),be&&be(e,t)},F.unmount=function(e){xe&&xe(e);var t,n,r=e.__c;r&&r.__H&&(r.__H.__.some(function(r){try{if(r.__P&&r.__c){if(n===void 0){for(n=e.__;n&&(!n.__c||!n.__c.__P);)n=n.__;n&&=n.__c}r.__P=n,Ae(ge.push(r))}else je(r)}catch(e){t=e}}),r.__H=void 0,t&&F.__e(t,r.__v))};var Oe=typeof requestAnimationFrame==`function`;function ke(e){var t,n=function(){clearTimeout(r),Oe&&cancelAnimationFrame(t),setTimeout(e)},r=setTimeout(n,35);Oe&&(t=requestAnimationFrame(n))}function Ae(e){e!=1&&fe==F.requestAnimationFrame||((fe=F.requestAnimationFrame)||ke)(De)}function je(e){var t=P,n=e.__c;typeof n==`function`&&(e.__c=void 0,n()),P=t}function Me(e){var t=P;e.__c=e.__(),P=t}function Ne(e,t){return!e||e.length!=t.length||t.some(function(t,n){return!pe(t,e[n])})}var Pe=Symbol.for(`preact-signals`);function Fe(){if(Be>1)Be--;else{var e,t=!1;for((function(){var e=We;for(We=void 0;e!==void 0;){var t=e.S;if(t.v===e.v)for(var n=t.t;n!==void 0;n=n.x)n.i===e.i&&(n.i=t.i);e=e.o}})();ze!==void 0;){var n=ze;for(ze=void 0,Ve++;n!==void 0;){var r=n.u;if(n.u=void 0,n.f&=-3,!(8&n.f)&&qe(n))try{n.c()}catch(n){t||=(e=n,!0)}n=r}}if(Ve=0,Be--,t)throw e}}function Ie(e){if(Be>0)return e();Ue=++He,Be++;try{return e()}finally{Fe()}}var Le,I=void 0;function Re(e){var t=I,n=Le;I=void 0,Le=void 0;try{return e()}finally{I=t,Le=n}}var ze=void 0,Be=0,Ve=0,He=0,Ue=0,We=void 0,Ge=0;function Ke(e){if(I!==void 0){var t=e.n;if(t===void 0||t.t!==I)return t={i:0,S:e,p:I.s,n:void 0,t:I,e:void 0,x:void 0,r:t},I.s!==void 0&&(I.s.n=t),I.s=t,e.n=t,32&I.f&&e.S(t),t;if(t.i===-1)return t.i=0,t.n!==void 0&&(t.n.p=t.p,t.p!==void 0&&(t.p.n=t.n),t.p=I.s,t.n=void 0,I.s.n=t,I.s=t),t}}function L(e,t){this.v=e,this.i=0,this.n=void 0,this.t=void 0,this.l=0,this.W=t?.watched,this.Z=t?.unwatched,this.name=t?.name}L.prototype.brand=Pe,L.prototype.h=function(){return!0},L.prototype.S=function(e){var t=this,n=this.t;n!==e&&e.e===void 0&&(e.x=n,this.t=e,n===void 0?Re(function(){var e;(e=t.W)==null||e.call(t)}):n.e=e)},L.prototype.U=function(e){var t=this;if(this.t!==void 0){var n=e.e,r=e.x;n!==void 0&&(n.x=r,e.e=void 0),r!==void 0&&(r.e=n,e.x=void 0),e===this.t&&(this.t=r,r===void 0&&Re(function(){var e;(e=t.Z)==null||e.call(t)}))}},L.prototype.subscribe=function(e){var t=this;return tt(function(){var n=t.value;Re(function(){return e(n)})},{name:`sub`})},L.prototype.valueOf=function(){return this.value},L.prototype.toString=function(){return this.value+``},L.prototype.toJSON=function(){return this.value},L.prototype.peek=function(){var e=this;return Re(function(){return e.value})},Object.defineProperty(L.prototype,"value",{get:function(){var e=Ke(this);return e!==void 0&&(e.i=this.i),this.v},set:function(e){if(e!==this.v){if(Ve>100)throw Error(`Cycle detected`);(function(e){Be!==0&&Ve===0&&e.l!==Ue&&(e.l=Ue,We={S:e,v:e.v,i:e.i,o:We})})(this),this.v=e,this.i++,Ge++,Be++;try{for(var t=this.t;t!==void 0;t=t.x)t.t.N()}finally{Fe()}}}});function R(e,t){return new L(e,t)}function qe(e){for(var t=e.s;t!==void 0;t=t.n)if(t.S.i!==t.i||!t.S.h()||t.S.i!==t.i)return!0;return!1}function Je(e){for(var t=e.s;t!==void 0;t=t.n){var n=t.S.n;if(n!==void 0&&(t.r=n),t.S.n=t,t.i=-1,t.n===void 0){e.s=t;break}}}function Ye(e){for(var t=e.s,n=void 0;t!==void 0;){var r=t.p;t.i===-1?(t.S.U(t),r!==void 0&&(r.n=t.n),t.n!==void 0&&(t.n.p=r)):n=t,t.S.n=t.r,t.r!==void 0&&(t.r=void 0),t=r}e.s=n}function Xe(e,t){L.call(this,void 0,t),this.x=e,this.s=void 0,this.g=Ge-1,this.f=4}Xe.prototype=new L,Xe.prototype.h=function(){if(this.f&=-3,1&this.f)return!1;if((36&this.f)==32||(this.f&=-5,this.g===Ge))return!0;if(this.g=Ge,this.f|=1,this.i>0&&!qe(this))return this.f&=-2,!0;var e=I;try{Je(this),I=this;var t=this.x();(16&this.f||this.v!==t||this.i===0)&&(this.v=t,this.f&=-17,this.i++)}catch(e){this.v=e,this.f|=16,this.i++}return I=e,Ye(this),this.f&=-2,!0},Xe.prototype.S=function(e){if(this.t===void 0){this.f|=36;for(var t=this.s;t!==void 0;t=t.n)t.S.S(t)}L.prototype.S.call(this,e)},Xe.prototype.U=function(e){if(this.t!==void 0&&(L.prototype.U.call(this,e),this.t===void 0)){this.f&=-33;for(var t=this.s;t!==void 0;t=t.n)t.S.U(t)}},Xe.prototype.N=function(){if(!(2&this.f)){this.f|=6;for(var e=this.t;e!==void 0;e=e.x)e.t.N()}},Object.defineProperty(Xe.prototype,"value",{get:function(){if(1&this.f)throw Error(`Cycle detected`);var e=Ke(this);if(this.h(),e!==void 0&&(e.i=this.i),16&this.f)throw this.v;return this.v}});function z(e,t){return new Xe(e,t)}function Ze(e){var t=e.j;if(e.j=void 0,typeof t==`function`){Be++;var n=I;I=void 0;try{t()}catch(t){throw e.f&=-2,e.f|=8,Qe(e),t}finally{I=n,Fe()}}}function Qe(e){for(var t=e.s;t!==void 0;t=t.n)t.S.U(t);e.x=void 0,e.s=void 0,Ze(e)}function $e(e){if(I!==this)throw Error(`Out-of-order effect`);Ye(this),I=e,this.f&=-2;try{8&this.f&&Qe(this)}finally{Fe()}}function et(e,t){this.x=e,this.j=void 0,this.s=void 0,this.u=void 0,this.f=32,this.name=t?.name,Le&&Le.push(this)}et.prototype.c=function(){var e=this.S();try{if(8&this.f||this.x===void 0)return;var t=this.x();typeof t==`function`&&(this.j=t)}finally{e()}},et.prototype.S=function(){if(1&this.f)throw Error(`Cycle detected`);this.f|=1,this.f&=-9,Ze(this),Je(this),Be++;var e=I;return I=this,$e.bind(this,e)},et.prototype.N=function(){2&this.f||(this.f|=2,this.u=ze,ze=this)},et.prototype.d=function(){this.f|=8,1&this.f||Qe(this)},et.prototype.dispose=function(){this.d()};function tt(e,t){var n=new et(e,t);try{n.c()}catch(e){throw n.d(),e}var r=n.d.bind(n);return r[Symbol.dispose]=r,r}var nt,rt,it=typeof window<`u`&&!!window.__PREACT_SIGNALS_DEVTOOLS__,at=[];tt(function(){nt=this.N})();function ot(t,n){e[t]=n.bind(null,e[t]||function(){})}function st(e){if(rt){var t=rt;rt=void 0,t()}rt=e&&e.S()}function ct(e){var t=this,r=e.data,i=ut(r);i.name=`ReactiveDom`,i.value=r;var a=Ee(function(){for(var e=t,r=t.__v;r=r.__;)if(r.__c){r.__c.__$f|=4;break}var a=z(function(){var e=i.value.value;return e===0?0:!0===e?``:e||``}),o=z(function(){return!Array.isArray(a.value)&&!n(a.value)}),s=tt(function(){if(this.N=pt,o.value){var t=a.value;e.__v&&e.__v.__e&&e.__v.__e.nodeType===3&&(e.__v.__e.data=t)}}),c=t.__$u.d;return t.__$u.d=function(){s(),c.call(this)},[o,a]},[]),o=a[0],s=a[1];return o.value?s.peek():s.value}ct.displayName=`ReactiveTextNode`,Object.defineProperties(L.prototype,{constructor:{configurable:!0,value:y(x,null).constructor},type:{configurable:!0,value:ct},props:{configurable:!0,get:function(){var e=this;return{data:{get value(){return e.value}}}}},__b:{configurable:!0,value:1}}),ot(`__b`,function(e,t){if(st(),typeof t.type==`string`){var n,r=t.props;for(var i in r)if(i!==`children`){var a=r[i];a instanceof L&&(n||(t.__np=n={}),n[i]=a,r[i]=a.peek())}}e(t)}),ot(`__r`,function(e,t){if(e(t),t.type!==x){st();var n,r=t.__c;r&&(r.__$f&=-2,(n=r.__$u)===void 0&&(r.__$u=n=function(e,t){var n;return tt(function(){n=this},{name:t}),n.c=e,n}(function(e){return function(){var t;it&&((t=this.y)==null||t.call(this)),e.__$f|=1,e.setState({})}}(r),typeof t.type==`function`?t.type.displayName||t.type.name:``))),st(n)}}),ot(`__e`,function(e,t,n,r){st(),e(t,n,r)}),ot(`diffed`,function(e,t){st();var n;if(typeof t.type==`string`&&(n=t.__e)){var r=t.__np,i=t.props,a=n.U;if(a)for(var o in a){var s=a[o];s===void 0||r&&o in r||(s.d(),a[o]=void 0)}if(r)for(var c in a||(a={},n.U=a),r){var l=a[c],u=r[c];l===void 0?(l=lt(n,c,u,i),a[c]=l):l.o(u,i)}}e(t)});function lt(e,t,n,r){var i=t in e&&e.ownerSVGElement===void 0,a=R(n);return{o:function(e,t){a.value=e,r=t},d:tt(function(){this.N=pt;var n=a.value.value;r[t]!==n&&(r[t]=n,i?e[t]=n:n!=null&&(!1!==n||t[4]===`-`)?e.setAttribute(t,n):e.removeAttribute(t))})}}ot(`unmount`,function(e,t){if(typeof t.type==`string`){var n=t.__e;if(n){var r=n.U;if(r)for(var i in n.U=void 0,r){var a=r[i];a&&a.d()}}var o=t.__np;if(o){var s=t.props;for(var c in o)s[c]=o[c]}t.__np=void 0}else{var l=t.__c;if(l){l.__$f|=8;var u=l.__$u;u&&(l.__$u=void 0,u.d())}}e(t)}),ot(`__h`,function(e,t,n,r){r<3&&(t.__$f|=2),e(t,n,r)}),S.prototype.shouldComponentUpdate=function(e,t){if(this.__R)return!0;var n=this.__$u,r=n&&n.s!==void 0;for(var i in t)return!0;if(this.__f||typeof this.u==`boolean`&&!0===this.u){var a=2&this.__$f;if(!(r||a||4&this.__$f)||1&this.__$f)return!0}else if(!(r||4&this.__$f)||3&this.__$f)return!0;for(var o in e)if(o!==`__source`&&e[o]!==this.props[o])return!0;for(var s in this.props)if(!(s in e))return!0;return!1};function ut(e,t){return Ee(function(){return R(e,t)},[])}var dt=function(e){queueMicrotask(function(){queueMicrotask(e)})};function ft(){Ie(function(){for(var e;e=at.shift();)nt.call(e)})}function pt(){at.push(this)===1&&(e.requestAnimationFrame||dt)(ft)}var mt=new URL(`worker.js`,import.meta.url).href,ht=new URL(`files.js`,import.meta.url).href,B=class extends Error{},gt=class extends B{constructor(e){super(`The file ${e} could not be fetched; check that the server of the page still runs.`)}},_t=class extends B{constructor(){super(`It was cancelled.`)}},vt={core:{address:mt,path:`assets/worker.js`},files:{address:ht,path:`assets/files.js`}},yt=new Map;function bt(e){if(!yt.has(e)){let t=document.getElementById(e);yt.set(e,t&&JSON.parse(t.textContent))}return yt.get(e)}function xt(){return bt(`files`)!==null}function St(e){return`?${bt(`versions`)?.[e]??``}`}async function Ct(e){let t=bt(`files`);if(t===null){try{let t=await fetch(e+St(e));if(t.ok)return new Uint8Array(await t.arrayBuffer());if(t.status===404)return null}catch{}throw new gt(e)}let n=t[e];if(n===void 0)return null;let r=Uint8Array.from(atob(n),e=>e.charCodeAt(0)),i=new Blob([r]).stream().pipeThrough(new DecompressionStream(`gzip`));return new Uint8Array(await new Response(i).arrayBuffer())}async function wt(e){let{address:t,path:n}=vt[e],r;if(xt()){let e=await Ct(n),t=URL.createObjectURL(new Blob([e],{type:`text/javascript`}));r=new Worker(t),r.addEventListener(`message`,()=>URL.revokeObjectURL(t),{once:!0})}else r=new Worker(t+St(n),{type:`module`});let i=new Promise((e,t)=>{r.addEventListener(`error`,()=>t(new gt(n)))});return{worker:r,broken:i}}function Tt(e){let t=e&32768?-1:1,n=e>>10&31,r=e&1023;return n===0?t*r*2**-24:n===31?r?NaN:t*(1/0):t*(1+r/1024)*2**(n-15)}function Et(e){let t=Math.abs(e),n=Math.max(Math.floor(Math.log2(t)),-14),r=t*2**(10-n),i=Math.floor(r),a=r-i>.5||r-i===.5&&i%2==1,o=i+Number(a);return(e<0?32768:0)|o+(n+14<<10)}var Dt=class extends B{name=`FileError`},Ot=`urushi`,kt={U8:Uint8Array,U16:Uint16Array,F16:Uint16Array,F32:Float32Array,F64:Float64Array},At=class{description;entries;data;constructor(e){try{let t=new DataView(e.buffer,e.byteOffset,e.byteLength),n=8+Number(t.getBigUint64(0,!0)),{__metadata__:r,...i}=JSON.parse(new TextDecoder().decode(e.slice(8,n)));this.description=Object(JSON.parse(r?.[Ot]??`{}`)),this.entries=i,this.data=e.subarray(n)}catch{throw new Dt(`The file (${e.length} bytes) is no safetensors file, or truncated.`)}}shapeOf(e){let{shape:t}=Object(this.entries[e]);return Mt(t)?t:[]}bytes(e,t,n){let r=this.shapeOf(e),{dtype:i,data_offsets:a}=Object(this.entries[e]);if(r.join()!==n.join()||i!==t)throw new Dt(`The array '${e}' ${i?`has the shape (${r.join(`, `)}) and type ${i}`:`is missing`}; this page needs ${`(${n.join(`, `)}) and ${t}`}.`);let[o=0,s=-1]=Mt(a)?a:[];if(s!==o+n.reduce((e,t)=>e*t,kt[t].BYTES_PER_ELEMENT)||s>this.data.length)throw new Dt(`The array '${e}' does not fit the file; copy or create it again.`);return this.data.slice(o,s)}numbers(e,t){let{dtype:n}=Object(this.entries[e]),r=n&&n in kt?n:`F32`,i=new kt[r](this.bytes(e,r,t).buffer),a=r===`F16`?Float64Array.from(i,Tt):Float64Array.from(i);if(!a.every(Number.isFinite))throw new Dt(`The array '${e}' holds a number that is not finite.`);return a}};function jt(e,t){let n=0,r=Object.entries(t).map(([e,{dtype:t,shape:r,bytes:i}])=>{let a=n;return n+=i.length,[e,{dtype:t,shape:r,data_offsets:[a,n]}]}),i={[Ot]:JSON.stringify(e)},a=JSON.stringify({__metadata__:i,...Object.fromEntries(r)}),o=new TextEncoder().encode(a),s=8+Math.ceil(o.length/8)*8,c=new Uint8Array(s+n).fill(32,8,s);return new DataView(c.buffer).setBigUint64(0,BigInt(s-8),!0),c.set(o,8),Object.values(t).forEach(({bytes:e},t)=>{c.set(e,s+r[t][1].data_offsets[0])}),c}function Mt(e){return Array.isArray(e)&&e.every(e=>Number.isSafeInteger(e)&&e>=0)}function Nt(e,t){return Array.from({length:3},(n,r)=>e.subarray(r*t,(r+1)*t))}var V=Uint8Array,Pt=Uint16Array,Ft=Int32Array,It=new V([0,0,0,0,0,0,0,0,1,1,1,1,2,2,2,2,3,3,3,3,4,4,4,4,5,5,5,5,0,0,0,0]),Lt=new V([0,0,0,0,1,1,2,2,3,3,4,4,5,5,6,6,7,7,8,8,9,9,10,10,11,11,12,12,13,13,0,0]),Rt=new V([16,17,18,0,8,7,9,6,10,5,11,4,12,3,13,2,14,1,15]),zt=function(e,t){for(var n=new Pt(31),r=0;r<31;++r)n[r]=t+=1<<e[r-1];for(var i=new Ft(n[30]),r=1;r<30;++r)for(var a=n[r];a<n[r+1];++a)i[a]=a-n[r]<<5|r;return{b:n,r:i}},Bt=zt(It,2),Vt=Bt.b,Ht=Bt.r;Vt[28]=258,Ht[258]=28;var Ut=zt(Lt,0);Ut.b;for(var Wt=Ut.r,Gt=new Pt(32768),H=0;H<32768;++H){var Kt=(H&43690)>>1|(H&21845)<<1;Kt=(Kt&52428)>>2|(Kt&13107)<<2,Kt=(Kt&61680)>>4|(Kt&3855)<<4,Gt[H]=((Kt&65280)>>8|(Kt&255)<<8)>>1}for(var qt=(function(e,t,n){for(var r=e.length,i=0,a=new Pt(t);i<r;++i)e[i]&&++a[e[i]-1];var o=new Pt(t);for(i=1;i<t;++i)o[i]=o[i-1]+a[i-1]<<1;var s;if(n){s=new Pt(1<<t);var c=15-t;for(i=0;i<r;++i)if(e[i])for(var l=i<<4|e[i],u=t-e[i],d=o[e[i]-1]++<<u,f=d|(1<<u)-1;d<=f;++d)s[Gt[d]>>c]=l}else for(s=new Pt(r),i=0;i<r;++i)e[i]&&(s[i]=Gt[o[e[i]-1]++]>>15-e[i]);return s}),Jt=new V(288),H=0;H<144;++H)Jt[H]=8;for(var H=144;H<256;++H)Jt[H]=9;for(var H=256;H<280;++H)Jt[H]=7;for(var H=280;H<288;++H)Jt[H]=8;for(var Yt=new V(32),H=0;H<32;++H)Yt[H]=5;var Xt=qt(Jt,9,0),Zt=qt(Yt,5,0),Qt=function(e){return(e+7)/8|0},$t=function(e,t,n){return(t==null||t<0)&&(t=0),(n==null||n>e.length)&&(n=e.length),new V(e.subarray(t,n))},en=[`unexpected EOF`,`invalid block type`,`invalid length/literal`,`invalid distance`,`stream finished`,`no stream handler`,,`no callback`,`invalid UTF-8 data`,`extra field too long`,`date not in range 1980-2099`,`filename too long`,`stream finishing`,`invalid zip data`],tn=function(e,t,n){var r=Error(t||en[e]);if(r.code=e,Error.captureStackTrace&&Error.captureStackTrace(r,tn),!n)throw r;return r},nn=function(e,t,n){n<<=t&7;var r=t/8|0;e[r]|=n,e[r+1]|=n>>8},rn=function(e,t,n){n<<=t&7;var r=t/8|0;e[r]|=n,e[r+1]|=n>>8,e[r+2]|=n>>16},an=function(e,t){for(var n=[],r=0;r<e.length;++r)e[r]&&n.push({s:r,f:e[r]});var i=n.length,a=n.slice();if(!i)return{t:fn,l:0};if(i==1){var o=new V(n[0].s+1);return o[n[0].s]=1,{t:o,l:1}}n.sort(function(e,t){return e.f-t.f}),n.push({s:-1,f:25001});var s=n[0],c=n[1],l=0,u=1,d=2;for(n[0]={s:-1,f:s.f+c.f,l:s,r:c};u!=i-1;)s=n[n[l].f<n[d].f?l++:d++],c=n[l!=u&&n[l].f<n[d].f?l++:d++],n[u++]={s:-1,f:s.f+c.f,l:s,r:c};for(var f=a[0].s,r=1;r<i;++r)a[r].s>f&&(f=a[r].s);var p=new Pt(f+1),m=on(n[u-1],p,0);if(m>t){var r=0,h=0,g=m-t,_=1<<g;for(a.sort(function(e,t){return p[t.s]-p[e.s]||e.f-t.f});r<i;++r){var v=a[r].s;if(p[v]>t)h+=_-(1<<m-p[v]),p[v]=t;else break}for(h>>=g;h>0;){var y=a[r].s;p[y]<t?h-=1<<t-p[y]++-1:++r}for(;r>=0&&h;--r){var b=a[r].s;p[b]==t&&(--p[b],++h)}m=t}return{t:new V(p),l:m}},on=function(e,t,n){return e.s==-1?Math.max(on(e.l,t,n+1),on(e.r,t,n+1)):t[e.s]=n},sn=function(e){for(var t=e.length;t&&!e[--t];);for(var n=new Pt(++t),r=0,i=e[0],a=1,o=function(e){n[r++]=e},s=1;s<=t;++s)if(e[s]==i&&s!=t)++a;else{if(!i&&a>2){for(;a>138;a-=138)o(32754);a>2&&(o(a>10?a-11<<5|28690:a-3<<5|12305),a=0)}else if(a>3){for(o(i),--a;a>6;a-=6)o(8304);a>2&&(o(a-3<<5|8208),a=0)}for(;a--;)o(i);a=1,i=e[s]}return{c:n.subarray(0,r),n:t}},cn=function(e,t){for(var n=0,r=0;r<t.length;++r)n+=e[r]*t[r];return n},ln=function(e,t,n){var r=n.length,i=Qt(t+2);e[i]=r&255,e[i+1]=r>>8,e[i+2]=e[i]^255,e[i+3]=e[i+1]^255;for(var a=0;a<r;++a)e[i+a+4]=n[a];return(i+4+r)*8},un=function(e,t,n,r,i,a,o,s,c,l,u){nn(t,u++,n),++i[256];for(var d=an(i,15),f=d.t,p=d.l,m=an(a,15),h=m.t,g=m.l,_=sn(f),v=_.c,y=_.n,b=sn(h),x=b.c,S=b.n,C=new Pt(19),w=0;w<v.length;++w)++C[v[w]&31];for(var w=0;w<x.length;++w)++C[x[w]&31];for(var T=an(C,7),E=T.t,D=T.l,ee=19;ee>4&&!E[Rt[ee-1]];--ee);var te=l+5<<3,O=cn(i,Jt)+cn(a,Yt)+o,k=cn(i,f)+cn(a,h)+o+14+3*ee+cn(C,E)+2*C[16]+3*C[17]+7*C[18];if(c>=0&&te<=O&&te<=k)return ln(t,u,e.subarray(c,c+l));var ne,A,j,re;if(nn(t,u,1+(k<O)),u+=2,k<O){ne=qt(f,p,0),A=f,j=qt(h,g,0),re=h;var ie=qt(E,D,0);nn(t,u,y-257),nn(t,u+5,S-1),nn(t,u+10,ee-4),u+=14;for(var w=0;w<ee;++w)nn(t,u+3*w,E[Rt[w]]);u+=3*ee;for(var ae=[v,x],oe=0;oe<2;++oe)for(var se=ae[oe],w=0;w<se.length;++w){var M=se[w]&31;nn(t,u,ie[M]),u+=E[M],M>15&&(nn(t,u,se[w]>>5&127),u+=se[w]>>12)}}else ne=Xt,A=Jt,j=Zt,re=Yt;for(var w=0;w<s;++w){var N=r[w];if(N>255){var M=N>>18&31;rn(t,u,ne[M+257]),u+=A[M+257],M>7&&(nn(t,u,N>>23&31),u+=It[M]);var ce=N&31;rn(t,u,j[ce]),u+=re[ce],ce>3&&(rn(t,u,N>>5&8191),u+=Lt[ce])}else rn(t,u,ne[N]),u+=A[N]}return rn(t,u,ne[256]),u+A[256]},dn=new Ft([65540,131080,131088,131104,262176,1048704,1048832,2114560,2117632]),fn=new V(0),pn=function(e,t,n,r,i,a){var o=a.z||e.length,s=new V(r+o+5*(1+Math.ceil(o/7e3))+i),c=s.subarray(r,s.length-i),l=a.l,u=(a.r||0)&7;if(t){u&&(c[0]=a.r>>3);for(var d=dn[t-1],f=d>>13,p=d&8191,m=(1<<n)-1,h=a.p||new Pt(32768),g=a.h||new Pt(m+1),_=Math.ceil(n/3),v=2*_,y=function(t){return(e[t]^e[t+1]<<_^e[t+2]<<v)&m},b=new Ft(25e3),x=new Pt(288),S=new Pt(32),C=0,w=0,T=a.i||0,E=0,D=a.w||0,ee=0;T+2<o;++T){var te=y(T),O=T&32767,k=g[te];if(h[O]=k,g[te]=O,D<=T){var ne=o-T;if((C>7e3||E>24576)&&(ne>423||!l)){u=un(e,c,0,b,x,S,w,E,ee,T-ee,u),E=C=w=0,ee=T;for(var A=0;A<286;++A)x[A]=0;for(var A=0;A<30;++A)S[A]=0}var j=2,re=0,ie=p,ae=O-k&32767;if(ne>2&&te==y(T-ae))for(var oe=Math.min(f,ne)-1,se=Math.min(32767,T),M=Math.min(258,ne);ae<=se&&--ie&&O!=k;){if(e[T+j]==e[T+j-ae]){for(var N=0;N<M&&e[T+N]==e[T+N-ae];++N);if(N>j){if(j=N,re=ae,N>oe)break;for(var ce=Math.min(ae,N-2),le=0,A=0;A<ce;++A){var ue=T-ae+A&32767,P=ue-h[ue]&32767;P>le&&(le=P,k=ue)}}}O=k,k=h[O],ae+=O-k&32767}if(re){b[E++]=268435456|Ht[j]<<18|Wt[re];var de=Ht[j]&31,fe=Wt[re]&31;w+=It[de]+Lt[fe],++x[257+de],++S[fe],D=T+j,++C}else b[E++]=e[T],++x[e[T]]}}for(T=Math.max(T,D);T<o;++T)b[E++]=e[T],++x[e[T]];u=un(e,c,l,b,x,S,w,E,ee,T-ee,u),l||(a.r=u&7|c[u/8|0]<<3,u-=7,a.h=g,a.p=h,a.i=T,a.w=D)}else{for(var T=a.w||0;T<o+l;T+=65535){var pe=T+65535;pe>=o&&(c[u/8|0]=l,pe=o),u=ln(c,u+1,e.subarray(T,pe))}a.i=o}return $t(s,0,r+Qt(u)+i)},mn=(function(){for(var e=new Int32Array(256),t=0;t<256;++t){for(var n=t,r=9;--r;)n=(n&1&&-306674912)^n>>>1;e[t]=n}return e})(),hn=function(){var e=-1;return{p:function(t){for(var n=e,r=0;r<t.length;++r)n=mn[n&255^t[r]]^n>>>8;e=n},d:function(){return~e}}},gn=function(e,t,n,r,i){if(!i&&(i={l:1},t.dictionary)){var a=t.dictionary.subarray(-32768),o=new V(a.length+e.length);o.set(a),o.set(e,a.length),e=o,i.w=a.length}return pn(e,t.level==null?6:t.level,t.mem==null?i.l?Math.ceil(Math.max(8,Math.min(13,Math.log(e.length)))*1.5):20:12+t.mem,n,r,i)},_n=function(e,t){var n={};for(var r in e)n[r]=e[r];for(var r in t)n[r]=t[r];return n},U=function(e,t,n){for(;n;++t)e[t]=n,n>>>=8};function vn(e,t){return gn(e,t||{},0,0)}var yn=function(e,t,n,r){for(var i in e){var a=e[i],o=t+i,s=r;Array.isArray(a)&&(s=_n(r,a[1]),a=a[0]),ArrayBuffer.isView(a)?n[o]=[a,s]:(n[o+=`/`]=[new V(0),s],yn(a,o,n,r))}},bn=typeof TextEncoder<`u`&&new TextEncoder,xn=typeof TextDecoder<`u`&&new TextDecoder;try{xn.decode(fn,{stream:!0})}catch{}function Sn(e,t){if(t){for(var n=new V(e.length),r=0;r<e.length;++r)n[r]=e.charCodeAt(r);return n}if(bn)return bn.encode(e);for(var i=e.length,a=new V(e.length+(e.length>>1)),o=0,s=function(e){a[o++]=e},r=0;r<i;++r){if(o+5>a.length){var c=new V(o+8+(i-r<<1));c.set(a),a=c}var l=e.charCodeAt(r);l<128||t?s(l):l<2048?(s(192|l>>6),s(128|l&63)):l>55295&&l<57344?(l=65536+(l&1047552)|e.charCodeAt(++r)&1023,s(240|l>>18),s(128|l>>12&63),s(128|l>>6&63),s(128|l&63)):(s(224|l>>12),s(128|l>>6&63),s(128|l&63))}return $t(a,0,o)}var Cn=function(e){var t=0;if(e)for(var n in e){var r=e[n].length;r>65535&&tn(9),t+=r+4}return t},wn=function(e,t,n,r,i,a,o,s){var c=r.length,l=n.extra,u=s&&s.length,d=Cn(l);U(e,t,o==null?67324752:33639248),t+=4,o!=null&&(e[t++]=20,e[t++]=n.os),e[t]=20,t+=2,e[t++]=n.flag<<1|(a<0&&8),e[t++]=i&&8,e[t++]=n.compression&255,e[t++]=n.compression>>8;var f=new Date(n.mtime==null?Date.now():n.mtime),p=f.getFullYear()-1980;if((p<0||p>119)&&tn(10),U(e,t,p<<25|f.getMonth()+1<<21|f.getDate()<<16|f.getHours()<<11|f.getMinutes()<<5|f.getSeconds()>>1),t+=4,a!=-1&&(U(e,t,n.crc),U(e,t+4,a<0?-a-2:a),U(e,t+8,n.size)),U(e,t+12,c),U(e,t+14,d),t+=16,o!=null&&(U(e,t,u),U(e,t+6,n.attrs),U(e,t+10,o),t+=14),e.set(r,t),t+=c,d)for(var m in l){var h=l[m],g=h.length;U(e,t,+m),U(e,t+2,g),e.set(h,t+4),t+=4+g}return u&&(e.set(s,t),t+=u),t},Tn=function(e,t,n,r,i){U(e,t,101010256),U(e,t+8,n),U(e,t+10,n),U(e,t+12,r),U(e,t+16,i)};function En(e,t){t||={};var n={},r=[];yn(e,``,n,t);var i=0,a=0;for(var o in n){var s=n[o],c=s[0],l=s[1],u=l.level==0?0:8,d=Sn(o),f=d.length,p=l.comment,m=p&&Sn(p),h=m&&m.length,g=Cn(l.extra);f>65535&&tn(11);var _=u?vn(c,l):c,v=_.length,y=hn();y.p(c),r.push(_n(l,{size:c.length,crc:y.d(),c:_,f:d,m,u:f!=o.length||m&&p.length!=h,o:i,compression:u})),i+=30+f+g+v,a+=76+2*(f+g)+(h||0)+v}for(var b=new V(a+22),x=i,S=a-i,C=0;C<r.length;++C){var d=r[C];wn(b,d.o,d,d.f,d.u,d.c.length);var w=30+d.f.length+Cn(d.extra);b.set(d.c,d.o+w),wn(b,i,d,d.f,d.u,d.c.length,d.o,d.m),i+=16+w+(d.m?d.m.length:0)}return Tn(b,i,r.length,S,x),b}function Dn(e){return En(e,{level:0,mtime:new Date(1980,0,1)})}var On=Uint32Array.from({length:256},(e,t)=>{let n=t;for(let e=0;e<8;e++)n=n>>>1^(n&1?3988292384:0);return n});function kn(e){return An(e).toString(16).padStart(8,`0`)}function An(e){let t=4294967295;for(let n of e)t=t>>>8^On[(t^n)&255];return(t^4294967295)>>>0}var jn=[`repeat`,`mirror`,`clamp`],Mn=4;function Nn({description:e}){return e.kind===`texture`}function Pn(e,t,{latentSize:n,fingerprint:r}){let{description:i}=e;if(i.version!==Mn)throw new B(`It is a texture of another version of Urushi; save it again.`);if(i.weights!==r)throw new B(`It was made with other networks; save the texture again.`);if(!Fn(i,n))throw new B(`The description of the texture is damaged; save it again.`);let{width:a,height:o,layout:s,place:c}=i,{channels:l,shared:u,stride:d,texel_bytes:f,high:p,low:m,same:h}=s;if(l!==1&&l!==3)throw new B(`It has other channels than red, green and blue.`);let g=t=>e.numbers(t,[n]),[_,v]=[g(`lowest`),g(`step`)],y=p.map((e,t)=>Array.from({length:3},(e,n)=>{let r=h[t]?0:u+(l===1?0:n)*d,i=e=>e<0?-1:r+e,a={high:i(p[t]),low:i(m[t])};return{lowest:_[t],step:v[t],...a}}));return{id:kn(t),file:t,size:[a,o],texels:e.bytes(`texels`,`U8`,[a*o,f]),texelBytes:f,usedBytes:u+l*d,numbers:y,toTexture:[0,1,2].flatMap(e=>c.to_texture.map(t=>t[e])),wrap:c.wrap,nearest:c.nearest}}function Fn(e,t){let{width:n,height:r,layout:i,place:a}=e,{channels:o,shared:s,stride:c,texel_bytes:l,high:u,low:d,same:f}=Object(i),{to_texture:p,wrap:m}=Object(a),h=(e,t,n)=>Array.isArray(e)&&e.length===t&&e.every(n),g=(e,t=0)=>Number.isInteger(e)&&Number(e)>=t,_=(e,t)=>g(e,-1)&&Number(e)<(f[t]?s:c);return[n,r].every(e=>g(e,1))&&[s,c].every(e=>g(e))&&s+o*c<=l&&h(f,t,e=>typeof e==`boolean`)&&[u,d].every(e=>h(e,t,_))&&h(p,2,e=>h(e,3,Number.isFinite))&&jn.includes(m)}function In(e){let{texels:t,texelBytes:n,numbers:r}=e,i=new Float64Array(n);for(let e=0;e<t.length;e++)i[e%n]+=t[e];let a=i.map(e=>e*n/t.length),o=new Float32Array(3*r.length);return r.forEach((e,t)=>{e.forEach(({lowest:e,step:n,high:i,low:s},c)=>{let l=i<0?0:s<0?a[i]:256*a[i]+a[s];o[c*r.length+t]=e+n*l})}),o}var Ln=e=>e===!0;function Rn(e,t,n){return r=>typeof r==`number`&&Number.isFinite(r)?Math.min(Math.max(r,e),t):n}function zn(e,t){return n=>e.find(e=>e===n)??t}function Bn(e){return t=>typeof t==`string`&&t.trim().slice(0,80).trim()||e}function Vn(e){return t=>Object.fromEntries(Object.entries(e).map(([e,n])=>[e,n(Object(t)[e])]))}function Hn(e,t){if(typeof e!=`object`||!e||Array.isArray(e))throw new B(`There is no description of ${t}.`);return e}var Un=[`red`,`green`,`blue`];function W(e){return typeof e==`number`?[e,e,e]:e}function G(e){return[e(0),e(1),e(2)]}function Wn(e){return e[0]===e[1]&&e[1]===e[2]?e[0]:e}function Gn(e,t){return typeof e==`number`?t(e):G(n=>t(e[n]))}function Kn(e,t){let[n,r]=[W(e),W(t)];return Wn(G(e=>n[e]/r[e]))}var qn={NATSUME:[[0,.035],[.15,.035],[.27,.032],[.3,.01],[.33,0],[.375,.03],[.425,.12],[.47,.26],[.497,.42],[.503,.56],[.502,.64],[.501,.672],[.498,.684],[.491,.69],[.491,.692],[.498,.698],[.501,.71],[.5,.76],[.492,.85],[.47,.93],[.42,.99],[.33,1.028],[.2,1.05],[.1,1.056],[0,1.058]]},Jn={BODY:[[0,0],[1.425,0],[1.5,.075],[1.5,.15],[1.5,.225],[2,.45],[2,.9],[2,1.35],[1.75,1.875],[1.5,2.4],[1.4375,2.53125],[1.3375,2.53125],[1.4,2.4]],LID:[[1.3,2.4],[1.3,2.55],[.4,2.55],[.2,2.7],[0,2.85],[.8,3.15],[0,3.15]],HANDLE:[[[-1.6,0,1.875],[-1.6,-.3,1.875],[-1.5,-.3,2.1],[-1.5,0,2.1]],[[-2.3,0,1.875],[-2.3,-.3,1.875],[-2.5,-.3,2.1],[-2.5,0,2.1]],[[-2.7,0,1.875],[-2.7,-.3,1.875],[-3,-.3,2.1],[-3,0,2.1]],[[-2.7,0,1.65],[-2.7,-.3,1.65],[-3,-.3,1.65],[-3,0,1.65]],[[-2.7,0,1.425],[-2.7,-.3,1.425],[-3,-.3,1.2],[-3,0,1.2]],[[-2.5,0,1.125],[-2.5,-.3,1.125],[-2.65,-.3,.9375],[-2.65,0,.9375]],[[-2,0,.9],[-2,-.3,.9],[-1.9,-.3,.6],[-1.9,0,.6]]],SPOUT:[[[1.7,0,1.425],[1.7,-.66,1.425],[1.7,-.66,.6],[1.7,0,.6]],[[2.6,0,1.425],[2.6,-.66,1.425],[3.1,-.66,.825],[3.1,0,.825]],[[2.3,0,2.1],[2.3,-.25,2.1],[2.4,-.25,2.025],[2.4,0,2.025]],[[2.7,0,2.4],[2.7,-.25,2.4],[3.3,-.25,2.4],[3.3,0,2.4]],[[2.8,0,2.475],[2.8,-.25,2.475],[3.525,-.25,2.49375],[3.525,0,2.49375]],[[2.9,0,2.475],[2.9,-.15,2.475],[3.45,-.15,2.5125],[3.45,0,2.5125]],[[2.8,0,2.4],[2.8,-.15,2.4],[3.2,-.15,2.4],[3.2,0,2.4]]]},Yn={AIR:1.000277,ETA_RANGE:[.5,3],MIN_ALPHA:.01,MIN_INDEX_STEP:9999e-7,TRAINED_G:[-.8,.9]},Xn={ROUGHNESSES:16,COSINES:48,TOTAL_CELLS:24,COARSE:[20,40],FINE:[28,57]},Zn={WI:[.6,0,.8],WO:[0,.6,.8]},Qn={POLAR_NODES:48,EDGE_NODES:192,AZIMUTH_NODES:16,MIN_TANGENT:1e-5},$n={FACTORS:5},er={SHAPE:[96,32,8],MIN_LOG:-25,MAX_LOG:16,MIN_COSINE:.005},tr={COSINES:{1:[1,.98,.925,.84,.735,.62,.51,.4,.315,.24,.175,.13,.09,.04,.013],2:[1,.95,.84,.7,.51,.36,.24,.15,.09]},AZIMUTHS:{1:[0],2:[0,.7853981633974483,1.5707963267948966]},NODES:{1:[24,4,.001,2e-4],2:[18,8,1,2e-4]}},nr={MARGIN:5e-4,LEAST_ALBEDO:1e-6,LEAST_REST:.005,NO_FACTOR:.999,ROUNDS:5,FACETS:512,ROUGH_GAIN:.003},rr={DEEPEST:12},ir={NO_LOBE:[1,0,0,0,1.5,0],LOBE_FEATURES:{1:6,2:8},NUMBERS:{1:[`alpha`,`normal`,`grazing`,`exact`,`eta`,`k`],2:[`alpha_u`,`normal`,`grazing`,`exact`,`eta`,`k`,`alpha_v`]},COSINES:[1,.5,.2]};function ar(e,t,n){let r=1-n,i=r*r,a=i*i*r;return e*(1-a)+t*a}function or(e,t,n){let r=e*e,i=1-r,a=(t-1)*(t+1)-n*n+r,o=Math.sqrt(a*a+t*t*4*(n*n)),s=Math.sqrt(.5*Math.max(o+a,0)),c=.5*Math.max(o-a,0),l=s-e,u=s+e,d=(l*l+c)/(u*u+c),f=s*e,p=c*r+1e-12,m=f-i,h=f+i,g=(m*m+p)/(h*h+p);return .5*d*(1+g)}function sr(e,t,n,r,i,a){let o=Math.min(Math.max(n,0),1),s=Math.min(Math.max(t,0),.99),c=1.139+1.17*o,l=(c-Math.sqrt(c*c-.556*(1-o)))/.278,u=(1-l*l)/(1-r*l*l),d=1.3333333333333333*s/(1-s)/(1-u*r),f=Math.abs(.5*Math.log(Math.min(Math.max(e,1e-6),1)))+d;i[a]=d/Math.max(f,1e-6)*u,i[1+a]=f}function cr(e){if(`sigmaT`in e)return{albedo:e.albedo,sigmaT:e.sigmaT};let t=new Float64Array(6),[n,r,i,a]=[e.color,e.body,e.bodyColor,e.g].map(W);for(let e=0;e<3;e++)sr(n[e],r[e],i[e],a[e],t,2*e);return{albedo:Wn(G(e=>t[2*e])),sigmaT:Wn(G(e=>t[2*e+1]))}}function lr(e){if(`color`in e)return{color:e.color,body:e.body,bodyColor:e.bodyColor};let[t,n,r]=[W(e.albedo),W(e.sigmaT),W(e.g)];if(Math.max(...t)===0)return{color:Wn(G(e=>Math.exp(-2*n[e]))),body:0,bodyColor:.8};let i=e=>n[e]*(1-t[e]*r[e]);return{color:1,body:Wn(G(e=>i(e)/(4/3+i(e)))),bodyColor:Wn(G(e=>vr(t[e],r[e])))}}function ur(e,t){let[n,r]=[W(e),W(t)];return{color:Wn(G(e=>Number((n[e]**(1-r[e])).toFixed(4)))),body:t,bodyColor:e}}function dr(e,t){return hr(e,ur(t,lr(e).body))}function fr({color:e,body:t,bodyColor:n}){let r=W(ur(n,t).color);return W(e).every((e,t)=>Math.abs(e-r[t])<.002)?n:Math.max(...W(t))===0&&e!==1?e:null}function pr(e){return fr(e)??(Math.max(...W(e.body))>.5?e.bodyColor:e.color)}function mr(e,t){let n=lr(e),r=fr(n);return hr(e,r===null?{...n,body:t}:ur(r,t))}function hr(e,t){let{albedo:n,sigmaT:r,...i}=e;return{...i,...t}}function gr(e,t){let n=W(lr(e).body);return G(e=>t*n[e]/(1+(t-1)*n[e]+1e-9))}function _r(e,t,n=[1,1,1]){let{color:r,bodyColor:i}=lr(e),[a,o,s]=[W(r),gr(e,t),W(i)];return G(e=>a[e]**t*((1-o[e])*n[e]+o[e]*s[e]))}function vr(e,t){let n=Math.sqrt((1-e)/(1-e*t));return(1-n)*(1-.139*n)/(1+1.17*n)}function yr({alpha:e,alphaV:t}){return t===void 0?{alpha:e}:{alpha:e,alphaV:t}}var br={alpha:.1,ior:1.5,color:1,body:0,bodyColor:.8,g:0};function xr(e,{id:t}){let n=e.coats.findIndex(e=>e.id===t),r=[...e.coats.slice(0,n).filter(t=>Cr(e,t)),e.coats[n]].map(e=>({...e,on:!0})),{coats:i}=Er({...e,coats:r,solo:null});return W(i.at(-1).eta).some(e=>e!==1)}function Sr(e){if(`reflectance`in e)return W(e.reflectance);if(`r0`in e)return W(e.r0);if(e.kind===`codes`||e.kind===`texels`)return[.5,.5,.5];let[t,n]=`k`in e?[W(e.eta),W(e.k)]:[W(e.ior),[0,0,0]];return G(e=>Number(or(1,t[e],n[e]).toFixed(3)))}function Cr(e,t){return e.solo===null?t.on:e.solo===t.id}function wr(e){let{bottom:t}=e;if(t.kind===`texels`)throw new B(`A texture of codes can be saved as a material file or a Mitsuba scene.`);let n=Yn.AIR,r=e=>(n=Tr(e.ior,n),{...e,ior:n}),i=e.coats.filter(t=>Cr(e,t)).map(r);return{bottom:t.kind===`dielectric`?r(t):t,coats:i}}function Tr(e,t){let[n,r]=Yn.ETA_RANGE,[i,a]=[W(e),W(t)];return Wn(G(e=>{let t=Math.min(Math.max(i[e],n*a[e]),r*a[e]);return t===i[e]?t:Number((t*(t>i[e]?1+1e-6:1-1e-6)).toFixed(6))}))}function Er(e){let{bottom:t,coats:n}=wr(e),r=Yn.AIR,i=n.map(e=>{let{ior:t,g:n,thickness:i=1}=e,a=Ar(t,r);r=t;let{albedo:o,sigmaT:s}=cr(e),c=Gn(s,e=>e*i);return{...yr(e),eta:a,albedo:o,sigmaT:c,g:n}}),a=Dr(t,Kn(r,Yn.AIR));return{bottom:a.kind===`dielectric`?Or(a):a,coats:i,energyCompensation:Fr(e)}}function Dr(e,t){return e.kind===`codes`?{...e,latents:kr(e.latents,t)}:e.kind===`dielectric`?{...e,ior:Kn(e.ior,t)}:`k`in e?{...e,eta:Kn(e.eta,t),k:Kn(e.k,t)}:e}function Or({ior:e,...t}){return{...t,eta:Ar(e,Yn.AIR)}}function kr(e,t){let n=e.length/3;return e.map((r,i)=>{let a=i%n===4||i%n===5,o=Math.floor(i/n);return a&&e[o*n+5]>0?r/W(t)[o]:r})}function Ar(e,t){return Gn(Kn(e,t),e=>Math.abs(e-1)<Yn.MIN_INDEX_STEP?1:e)}function jr(e){if(!(`alpha`in e)||e.alphaV===void 0)return 1;let t=W(e.alphaV),n=W(e.alpha).map((e,n)=>e/t[n]);return Math.max(...n,...n.map(e=>1/e))}function Mr({bottom:e,coats:t}){return e.kind===`codes`&&e.widths===2||[e,...t].some(e=>`alphaV`in e)}function Nr({bottom:e,coats:t}){return e.kind===`codes`&&e.widths===2||[e,...t].some(e=>jr(e)!==1)}function Pr(e){let t=wr(e);return(t.coats.length>0||t.bottom.kind===`conductor`)&&!Nr(t)}function Fr(e){return e.energyCompensation===!0&&Pr(e)}function Ir({bottom:e,coats:t}){return e.kind!==`texels`&&t.length<6}function Lr(e,t,n){let r=[...e.coats],[i]=r.splice(t,1);return i===void 0?e:(r.splice(Math.max(0,Math.min(n,r.length)),0,i),{...e,coats:r})}function Rr(e){if(!Ir(e))return e;let{coats:t}=e,n=t[0]??br,r=Math.max(0,...t.map(e=>e.id))+1,i={...br,...yr(n),ior:n.ior,id:r,on:!0};return{...e,coats:[i,...t]}}function zr(e,t){return{...e,coats:e.coats.filter(e=>e.id!==t),solo:e.solo===t?null:e.solo}}var Br={label:`Roughness α`,hint:`GGX width of the surface: 0.01 is a polished mirror, 1 is matt.`,low:.01,high:1,power:2,fallback:.1},Vr=qr(`Gloss`,`How sharply the surface reflects: 1 is a polished mirror, 0 is matt.`,.7);function Hr(e){return Number((1-$r(Br,e)).toFixed(3))}function Ur(e){let t=Br.low+(Br.high-Br.low)*(1-e)**Br.power,n=[3,4,5].find(n=>Hr(Number(t.toFixed(n)))===e);return Number(t.toFixed(n??6))}var Wr={alpha:{...Br,label:`Roughness αᵤ`,hint:`GGX width along the tangent, the direction of brushing or turning.`},alphaV:{...Br,label:`Roughness αᵥ`,hint:`GGX width across the tangent.`}},Gr={label:`Tangent angle`,hint:`Angle by which the tangent of all layers is turned about the normal, in degrees.`,low:-90,high:90,power:1,fallback:0};function Kr(e){return((e+180)%360+360)%360-180}function qr(e,t,n){return{label:e,hint:t,low:0,high:1,power:1,fallback:n}}function Jr(e,t,n){return{...qr(e,t,n),isColour:!0}}var Yr=Jr(`Colour`,`Colour of the coat: of its dye where it is clear, of its pigment where it is opaque.`,1),Xr={alpha:Br,color:Jr(`Dye`,`Colour of a clear dye: what light keeps that passes the coat twice, at thickness 1.`,1),body:qr(`Opacity`,`How opaque the pigment is, at thickness 1: 0 is clear, 1 is opaque paint.`,0),bodyColor:Jr(`Pigment`,`Colour of an opaque layer of the pigment.`,.8),thickness:{label:`Thickness`,hint:`Factor of the medium's depth.`,low:0,high:100,slide:4,power:2,fallback:1},ior:{label:`Index n`,hint:`Index of refraction: water 1.33, varnish 1.5. Between equal indices there is no surface.`,low:.51,high:3,power:1,fallback:1.5},sigmaT:{label:`Depth σₜ`,hint:`Optical depth of the medium: how often light is absorbed or scattered on its way.`,low:0,high:1e3,slide:10,power:3,fallback:0},albedo:qr(`Scattering`,`Single-scattering albedo of the medium: 0 only absorbs, 1 only scatters.`,0),g:{label:`Direction g`,hint:`Asymmetry of the scattering: above 0 forwards, below 0 backwards.`,low:-.99,high:.99,power:1,fallback:0}},Zr={alpha:{...Br,fallback:.2},r0:Jr(`Reflectance`,`Reflectance at normal incidence.`,.9),eta:{label:`Index n`,hint:`Real part of the index of refraction.`,low:0,high:10,slide:6,power:2,fallback:1.5},ior:Xr.ior,k:{label:`Extinction k`,hint:`Imaginary part of the index of refraction.`,low:0,high:20,slide:10,power:1,fallback:3},reflectance:Jr(`Reflectance`,`Reflectance of the matt surface.`,.5)};function Qr({low:e,high:t},n){return Math.min(Math.max(n,e),t)}function $r({low:e,high:t,slide:n=t,power:r},i){return Math.min(Math.max((i-e)/(n-e),0),1)**(1/r)}function ei(e,t){let{low:n,high:r,slide:i=r,power:a}=e;return Qr(e,ri(n+(i-n)*t**a))}function ti(e,t){return Math.round($r(e,t)*500)}function ni(e,t,n){let r=Math.sign(t-ti(e,n)),i=t;for(;r!==0&&i>0&&i<500&&ei(e,i/500)===n;)i+=r;return ei(e,i/500)}function ri(e){let t=Math.abs(e)>=.1||e===0?3:4;return Number(e.toFixed(t))}var ii=[{name:`Black urushi`,bottom:{kind:`diffuse`,reflectance:[.012,.01,.01]},coats:[{alpha:.02,ior:1.53,g:0,color:[.85,.65,.45],body:0,bodyColor:.8}]},{name:`Vermilion urushi`,bottom:{kind:`diffuse`,reflectance:[.012,.01,.01]},coats:[{alpha:.02,ior:1.53,g:0,color:[.85,.65,.45],body:0,bodyColor:.8},{alpha:.05,ior:1.53,g:0,color:1,body:1,bodyColor:[.62,.055,.02]}]},{name:`Shellac on maple`,bottom:{kind:`diffuse`,reflectance:[.62,.44,.27]},coats:[{alpha:.05,ior:1.516,g:0,color:[.95,.8,.52],body:0,bodyColor:.8}]},{name:`Spirit varnish on spruce`,bottom:{kind:`diffuse`,reflectance:[.58,.4,.22]},coats:[{alpha:.04,ior:1.52,g:0,color:[.86,.42,.12],body:0,bodyColor:.8}]},{name:`Oil on walnut`,bottom:{kind:`diffuse`,reflectance:[.2,.105,.052]},coats:[{alpha:.3,ior:1.48,g:0,color:[.97,.9,.74],body:0,bodyColor:.8}],energyCompensation:!0},{name:`Polyurethane on oak`,bottom:{kind:`diffuse`,reflectance:[.4,.27,.15]},coats:[{alpha:.12,ior:1.5,g:0,color:[.97,.92,.8],body:0,bodyColor:.8}],energyCompensation:!0},{name:`French polish on mahogany`,bottom:{kind:`diffuse`,reflectance:[.26,.085,.042]},coats:[{alpha:.015,ior:1.516,g:0,color:1,body:0,bodyColor:.8},{alpha:.05,ior:1.516,g:0,color:[.9,.66,.4],body:0,bodyColor:.8}]},{name:`Solid white car paint`,bottom:{kind:`diffuse`,reflectance:.3},coats:[{alpha:.015,ior:1.5,g:0,color:1,body:0,bodyColor:.8},{alpha:.1,ior:1.5,g:0,color:1,body:1,bodyColor:.86}]},{name:`Metallic red car paint`,bottom:{kind:`conductor`,alpha:.33,eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},coats:[{alpha:.015,ior:1.5,g:0,color:1,body:0,bodyColor:.8},{alpha:.1,ior:1.5,g:0,color:[.7,.05,.03],body:.04,bodyColor:[.6,.04,.03]}]},{name:`Candy blue car paint`,bottom:{kind:`conductor`,alpha:.22,eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},coats:[{alpha:.015,ior:1.5,g:0,color:1,body:0,bodyColor:.8},{alpha:.1,ior:1.5,g:0,color:[.04,.16,.72],body:0,bodyColor:.8}]},{name:`White enamel`,bottom:{kind:`conductor`,alpha:.3,r0:[.53,.51,.5]},coats:[{alpha:.025,ior:1.55,g:0,color:1,body:1,bodyColor:[.86,.85,.82],thickness:2}]},{name:`Blue enamel on copper`,bottom:{kind:`conductor`,alpha:.15,eta:[.201,.924,1.102],k:[3.913,2.453,2.142]},coats:[{alpha:.025,ior:1.55,g:0,color:[.05,.18,.62],body:0,bodyColor:.8}]},{name:`Green enamel on silver`,bottom:{kind:`conductor`,alpha:.12,eta:[.155,.117,.138],k:[4.828,3.122,2.147]},coats:[{alpha:.025,ior:1.55,g:0,color:[.08,.52,.2],body:0,bodyColor:.8}]},{name:`Celadon`,bottom:{kind:`diffuse`,reflectance:[.66,.66,.62]},coats:[{alpha:.04,ior:1.52,g:0,color:[.58,.83,.7],body:.12,bodyColor:[.8,.88,.82]}]},{name:`Tenmoku`,bottom:{kind:`diffuse`,reflectance:[.17,.075,.035]},coats:[{alpha:.04,ior:1.56,g:0,color:[.2,.06,.02],body:0,bodyColor:.8}]},{name:`Honey glaze`,bottom:{kind:`diffuse`,reflectance:[.75,.7,.62]},coats:[{alpha:.03,ior:1.52,g:0,color:[.8,.52,.22],body:0,bodyColor:.8}]},{name:`Lacquered brass`,bottom:{kind:`conductor`,alpha:.12,eta:[.446,.538,1.02],k:[3.52,2.72,1.91]},coats:[{alpha:.06,ior:1.49,g:0,color:[.98,.94,.84],body:0,bodyColor:.8}]},{name:`Gilding under shellac`,bottom:{kind:`conductor`,alpha:.2,eta:[.143,.375,1.442],k:[3.983,2.386,1.603]},coats:[{alpha:.05,ior:1.516,g:0,color:[.97,.86,.62],body:0,bodyColor:.8}]},{name:`Anodised aluminium`,bottom:{kind:`conductor`,alpha:.25,eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},coats:[{alpha:.2,ior:1.65,g:0,color:[.1,.3,.66],body:0,bodyColor:.8}],energyCompensation:!0},{name:`Tarnished silver`,bottom:{kind:`conductor`,alpha:.15,eta:[.155,.117,.138],k:[4.828,3.122,2.147]},coats:[{alpha:.2,ior:2.2,g:0,color:[.6,.45,.24],body:.05,bodyColor:[.1,.08,.06]}],energyCompensation:!0},{name:`Red nail lacquer`,bottom:{kind:`diffuse`,reflectance:[.72,.5,.42]},coats:[{alpha:.02,ior:1.48,g:0,color:1,body:.9,bodyColor:[.55,.02,.04]}]},{name:`Sheer pink nail lacquer`,bottom:{kind:`diffuse`,reflectance:[.72,.5,.42]},coats:[{alpha:.02,ior:1.48,g:0,color:[.98,.72,.74],body:.1,bodyColor:[.9,.6,.62]}]},{name:`Brushed chromium`,bottom:{kind:`conductor`,alpha:.06,alphaV:.3,eta:[4.37,2.917,1.655],k:[5.207,4.231,3.755]},coats:[]},{name:`Brushed copper under lacquer`,bottom:{kind:`conductor`,alpha:.06,alphaV:.3,eta:[.201,.924,1.102],k:[3.913,2.453,2.142]},coats:[{alpha:.03,ior:1.49,g:0,color:1,body:0,bodyColor:.8}]}],ai={Gold:{eta:[.143,.375,1.442],k:[3.983,2.386,1.603]},Silver:{eta:[.155,.117,.138],k:[4.828,3.122,2.147]},Copper:{eta:[.201,.924,1.102],k:[3.913,2.453,2.142]},Aluminium:{eta:[1.658,.88,.521],k:[9.224,6.27,4.837]},Chromium:{eta:[4.37,2.917,1.655],k:[5.207,4.231,3.755]},Tungsten:{eta:[4.371,3.3,2.998],k:[3.501,2.605,2.273]}},oi=(e,{eta:t,k:n})=>({name:e,bottom:{kind:`conductor`,alpha:.05,eta:t,k:n},coats:[]}),si=(e,t)=>({name:e,bottom:{kind:`diffuse`,reflectance:t},coats:[{...br,alpha:.05}]}),ci=[oi(`Gold`,ai.Gold),oi(`Silver`,ai.Silver),oi(`Chrome`,ai.Chromium),si(`Black`,.01),si(`White`,.8)],li=[...ci,...ii].map(({coats:e,...t})=>({...t,coats:e.map((e,t)=>({...e,id:t+1,on:!0})),solo:null})),ui={Lacquer:/urushi|nail/,Wood:/ on (maple|spruce|walnut|oak|mahogany)/,"Car paint":/car paint/,"Enamel and glaze":/enamel|glaze|celadon|tenmoku/i,Metal:/brass|gilding|aluminium|silver|chromium|copper/i};function di({name:e}){return ci.some(t=>t.name===e)?`Plain`:Object.entries(ui).find(([,t])=>t.test(e))?.[0]??``}function fi(e){let t=li.find(({name:t})=>t===e.name);return t!==void 0&&pi(t)!==pi(e)?`${e.name} (modified)`:e.name}function pi({solo:e,...t}){return JSON.stringify(t,(e,t)=>typeof t!=`object`||Array.isArray(t)?t:Object.fromEntries(Object.entries(t).filter(([,e])=>e!==!1).sort()))}function mi(e){return li.find(t=>t.name===e)}var hi=[`goblet`,`ball`,`caddy`,`teapot`,`plate`,`vase`,`bowl`,`sheet`],gi=[`studio`,`sky`,`room`,`own`],_i=[`neutral`,`filmic`,`none`],vi=[`off`,`side`,`swipe`,`difference`],yi=[2,10,50],bi=Vn({azimuth:Rn(-180,180,20),elevation:Rn(-10,85,18),zoom:Rn(.5,4,1),fov:Rn(5,60,24),pan:e=>{let[t,n]=Array.isArray(e)?e:[];return[Rn(-2,2,0)(t),Rn(-2,2,0)(n)]}}),xi=Vn({active:zn([0,1],0),comparison:zn(vi,`off`),edge:Rn(0,1,.5),scale:zn(yi,50),object:zn([...hi,`own`],`goblet`),mesh:Bn(``),environment:zn(gi,`studio`),panorama:Bn(``),rotation:Rn(-180,180,0),exposure:Rn(-6,6,0),view:bi,tone:zn(_i,`neutral`),background:e=>e===`transparent`||/^#[0-9a-f]{6}$/.test(String(e))?String(e):`environment`,turntable:Ln,plots:Ln,incidence:Rn(0,89,45)}),Si={materials:[mi(`Vermilion urushi`),mi(`Gilding under shellac`)],...xi({})};function Ci(e){let{materials:t}=Hn(e,`the state`);if(!Array.isArray(t)||t.length<1||t.length>2)throw new B(`The state has no materials.`);let[n,r=Si.materials[1]]=t.map(wi);return{materials:[n,r],...xi(e)}}function wi(e){let t=Hn(e,`the material`),{coats:n=[],solo:r}=t;if(!Array.isArray(n)||n.length>6)throw new B(`A material has at most 6 coats.`);let i=Di(t.bottom);if(i.kind===`texels`&&n.length>0)throw new B(`A texture of codes cannot be coated on this page.`);return{name:Bn(`Material`)(t.name),bottom:i,coats:n.map(Ei),...t.energyCompensation===!0?{energyCompensation:!0}:{},...`rotation`in t?{rotation:Rn(-180,180,0)(t.rotation)}:{},solo:r===0?0:Ti(n,r)}}function Ti(e,t){let n=e.findIndex((e,n)=>(Object(e).id??n+1)===t);return n<0?null:n+1}function Ei(e,t){let n=Hn(e,`a coat`),r=Ai(n,Xr),i=`albedo`in n||`sigmaT`in n?r(`albedo`,`sigmaT`):r(`color`,`body`,`bodyColor`),a=W(r(`thickness`).thickness)[0];return{id:t+1,on:n.on!==!1,...ki(n,Xr),...r(`ior`,`g`),...i,...a===1?{}:{thickness:a}}}function Di(e){let t=Hn(e,`the bottom`),n=Ai(t,Zr),r=()=>ki(t,Zr);switch(t.kind){case`conductor`:{let e=`r0`in t?n(`r0`):n(`eta`,`k`);return{kind:`conductor`,...r(),...e}}case`dielectric`:return{kind:`dielectric`,...r(),...n(`ior`)};case`diffuse`:return{kind:`diffuse`,...n(`reflectance`)};case`codes`:return{kind:`codes`,latents:ji(t.latents),...t.widths===2?{widths:2}:{},...`table`in t?{table:Oi(t.table,`table`)}:{},...t.besideLobe===!0?{besideLobe:!0}:{}};case`texels`:return{kind:`texels`,texture:Oi(t.texture,`texture`)};default:throw new B(`The bottom is of no kind that this page knows.`)}}function Oi(e,t){if(typeof e!=`string`||!/^[0-9a-f]{8}$/.test(e))throw new B(`The name of the bottom's ${t} is damaged.`);return e}function ki(e,{alpha:t}){let n=Ai(e,{alpha:t,alphaV:t});return`alphaV`in e?n(`alpha`,`alphaV`):n(`alpha`)}function Ai(e,t){let n=n=>{let{[n]:r=t[n].fallback}=e,i=[r].flat();if(![1,3].includes(i.length)||!i.every(Number.isFinite))throw new B(`The parameter ${n} is neither a number nor three.`);return Gn(i.length===1?i[0]:i,e=>Qr(t[n],e))};return(...e)=>Object.fromEntries(e.map(e=>[e,n(e)]))}function ji(e){if(!(Array.isArray(e)&&e.length>0&&e.length<=768)||e.length%3||!e.every(Number.isFinite))throw new B(`The codes of the bottom are damaged.`);return new Float32Array(e)}var K=R(Si),q=z(()=>K.value.materials[K.value.active]),Mi=R(null),Ni=R(null);async function Pi(e,t){if(Ni.value!==null)throw new B(`Something else is being done; wait until it has ended, or cancel it.`);let n=new AbortController,r=t=>{Ni.value={text:e,share:t,cancel:()=>n.abort()}};r(),Li(e);try{return await t(n.signal,e=>{n.signal.aborted||r(e)})}finally{Ni.value=null}}var Fi=R(``),Ii=0;function Li(e){Fi.value=e,clearTimeout(Ii),Ii=setTimeout(()=>{Fi.value=``},4e3)}var Ri=700,zi=R([]),Bi=R([]),Vi={kind:``,time:-1/0},Hi=z(()=>zi.value.length>0),Ui=z(()=>Bi.value.length>0);function J(e,t=``){let n=performance.now(),r=t!==``&&t===Vi.kind&&n-Vi.time<Ri;Vi={kind:t,time:n},r||(zi.value=[...zi.value,K.value].slice(-200)),Bi.value=[],Y(e)}function Wi(e,t=``){let{materials:n,active:r}=K.value;J({materials:r===0?[e,n[1]]:[n[0],e]},t)}function Y(e){K.value={...K.value,...e}}function Gi(){qi(zi,Bi,`Undone`)}function Ki(){qi(Bi,zi,`Redone`)}function qi(e,t,n){let r=e.value.at(-1);if(r===void 0)return;e.value=e.value.slice(0,-1),t.value=[...t.value,K.value],Vi.kind=``;let{view:i,turntable:a,plots:o,edge:s,scale:c,incidence:l}=K.value;K.value={...r,view:i,turntable:a,plots:o,edge:s,scale:c,incidence:l},Li(n)}function X(e,t,n=``){e instanceof _t?Li(n+e.message):e instanceof B?Mi.value={text:n+e.message,retry:e instanceof gt?t:void 0}:(console.error(e),Mi.value={text:`${n}Something went wrong (${e}); load the page anew.`})}function Ji(e){Mi.value={text:e}}function Yi(e,t){try{t?J(e()):K.value=e()}catch(e){X(e)}}var Xi=er.SHAPE.reduce((e,t)=>e*t,1),Zi=Xi*3;1+$n.FACTORS;function Qi(e){return Array.from({length:e.length/2},(t,n)=>[e[2*n],e[2*n+1]])}var $i=[ea([0,0],[.39,0]),[...Qi([.39,0,.405,0,.41,.01]),...ea([.41,.02],[.41,.1])],ea([.41,.1],[.23,.1]),Qi([.23,.1,.15,.12,.13,.22,.2,.28]),Qi([.2,.28,.4,.3,.56,.42,.59,.66,.6,.74,.61,.785,.66,.81,.672,.816,.666,.828,.652,.824,.585,.8,.575,.77,.565,.7,.545,.58,.36,.53,0,.53])];function ea(e,t){let n=n=>[e[0]+n*(t[0]-e[0]),e[1]+n*(t[1]-e[1])];return[e,n(1/3),n(2/3),t]}var ta=Qi([0,.04,.18,.04,.27,.03,.31,0,.36,0,.38,.05,.42,.2,.56,.5,.66,.85,.67,1.12,.58,1.4,.38,1.62,.24,1.78,.2,1.95,.22,2.12,.3,2.24,.335,2.285,.325,2.3,.29,2.28,.2,2.16,.16,1.95,.16,1.8,.1,1.7,0,1.68]),na=Qi([0,.05,.2,.05,.26,.03,.28,0,.33,0,.35,.05,.48,.12,.66,.3,.76,.52,.8,.7,.81,.745,.795,.76,.77,.745,.755,.7,.71,.53,.6,.33,.42,.17,.24,.11,0,.1]),ra=Qi([0,.03,.3,.03,.4,.02,.43,0,.46,0,.48,.03,.62,.07,.8,.12,.87,.145,.885,.16,.87,.175,.8,.165,.66,.13,.58,.095,.5,.085,.3,.08,0,.08]);function ia(e,t){return[e[0]-t[0],e[1]-t[1],e[2]-t[2]]}function aa(e,t){return e[0]*t[0]+e[1]*t[1]+e[2]*t[2]}function oa(e,t){return[e[1]*t[2]-e[2]*t[1],e[2]*t[0]-e[0]*t[2],e[0]*t[1]-e[1]*t[0]]}function sa(e){let t=Math.hypot(...e)||1;return[e[0]/t,e[1]/t,e[2]/t]}function ca({radius:e}){return 3*e}var la={goblet:()=>$i.map(e=>ya(pa(e),112,(e.length-1)*5)),ball:()=>[ya(da,96,64)],caddy:()=>[ya(fa(qn.NATSUME),96,128)],plate:()=>[ya(fa(ra),128,96)],bowl:()=>[ya(fa(na),128,128)],sheet:()=>[Ca(96)],vase:()=>[ya(fa(ta),96,128)],teapot:()=>[ya(pa(Jn.BODY),96,72),ya(pa(Jn.LID),72,48),Da(va(Jn.HANDLE),32,60),Da(va(Jn.SPOUT),32,48)]};function ua(e){return Oa(la[e]())}function da(e){let t=Math.PI*(e-.5);return[Math.cos(t),1+Math.sin(t)]}function fa(e){let t=e.length-1,n=([e,t])=>[-e,t],r=[n(e[1]),...e,n(e[t-1])];return e=>{let n=e*t,i=Math.min(Math.floor(n),t-1),a=n-i;return ga([(1-a)**3/6,(3*a**3-6*a**2+4)/6,(-3*a**3+3*a**2+3*a+1)/6,a**3/6],r.slice(i,i+4))}}function pa(e){return t=>ga(...ma(e,t))}function ma(e,t){let n=(e.length-1)/3,r=Math.min(Math.floor(t*n),n-1);return[ha(t*n-r),e.slice(3*r,3*r+4)]}function ha(e){let t=1-e;return[t**3,3*t**2*e,3*t*e**2,e**3]}function ga(e,t){let n=n=>t.reduce((t,r,i)=>t+e[i]*r[n],0);return t[0].map((e,t)=>n(t))}var _a=.15;function va(e){return(t,n)=>{let r=ha(t<.5?2*t:2-2*t),[i,a]=ma(e,n),[o,s,c]=ga(i,a.map(e=>ga(r,e)));return[o,t<.5?s:-s,c+_a]}}function ya(e,t,n){return Da((t,n)=>{let[r,i]=e(n),a=2*Math.PI*t;return[r*Math.cos(a),r*Math.sin(a),i]},t,n)}var ba=.09,xa=8,Sa=6;function Ca(e){let t={vertices:[],tangents:[],faces:[]};for(let n of[1,-1]){let r=t.vertices.length/8;for(let i=0;i<=e;i++)for(let a=0;a<=e;a++){let[o,s,c]=Ta(2*a/e-1,2*i/e-1),l=ba*(1-c**Sa)**(1/Sa)+.03*(1-c*c),u=sa(Ea(o,s,l));if(t.vertices.push(o,s,ba+n*l,u[0],u[1],n*u[2]),t.vertices.push(.5+.5*o,.5+.5*n*s),t.tangents.push(...wa([u[0],u[1],n*u[2]],n)),i===e||a===e)continue;let d=r+i*(e+1)+a,f=d+e+1;n>0?t.faces.push(d,d+1,f+1,d,f+1,f):t.faces.push(d,f+1,d+1,d,f,f+1)}}return t}function wa([e,t,n],r){let i=[1-e*e,-e*t,-e*n];return Math.hypot(...i)>1e-6?sa(i):[0,0,-r*Math.sign(e)]}function Ta(e,t){let n=Math.max(Math.abs(e),Math.abs(t));if(n===0)return[0,0,0];let r=(Math.abs(e)**xa+Math.abs(t)**xa)**(1/xa),i=Math.sin(Math.PI/2*n);return[e/r*i,t/r*i,i]}function Ea(e,t,n){let r=(Math.abs(e)**xa+Math.abs(t)**xa)**(1/xa),i=Math.max(n-.03*(1-r*r),0)/ba,a=r**5+i**5*.06*r/ba,o=e=>r===0?0:Math.sign(e)*(Math.abs(e)/r)**7;return[a*o(e),a*o(t),i**5/ba]}function Da(e,t,n){let r=[],i=[],a=[],o=1e-4;for(let s=0;s<=n;s++){let c=s/n,l=Math.min(Math.max(c,2*o),1-2*o);for(let u=0;u<=t;u++){let d=u%t/t,f=ia(e((d+o)%1,l),e((d+1-o)%1,l)),p=ia(e(d,l+o),e(d,l-o)),[m,h]=e(d,c),g=Math.min(Math.max((u+(Math.hypot(m,h)>1e-6?0:s===0?.5:-.5))/t,0),1);if(r.push(...e(d,c),...sa(oa(f,p)),g,c),i.push(...sa(f)),s===n||u===t)continue;let _=s*(t+1)+u,v=_+t+1;a.push(_,_+1,v+1,_,v+1,v)}}return{vertices:r,tangents:i,faces:a}}function Oa(e){let t=t=>e.reduce((e,n)=>e+n[t].length,0),n=new Float32Array(t(`vertices`)),r=new Float32Array(t(`tangents`)),i=new Uint32Array(t(`faces`)),[a,o]=[0,0];for(let t of e){n.set(t.vertices,8*a),r.set(t.tangents,3*a);for(let e=0;e<t.faces.length;e++)i[o++]=a+t.faces[e];a+=t.vertices.length/8}let s=[1/0,1/0,1/0],c=[-1/0,-1/0,-1/0];for(let e=0;e<n.length;e+=8)for(let t=0;t<3;t++)s[t]=Math.min(s[t],n[e+t]),c[t]=Math.max(c[t],n[e+t]);let l=[0,1,2].map(e=>(s[e]+c[e])/2),[u,d]=[0,0];for(let e=0;e<n.length;e+=8){let[t,r]=[n[e]-l[0],n[e+1]-l[1]];u=Math.max(u,Math.hypot(t,r,n[e+2]-l[2])),d=Math.max(d,Math.hypot(t,r))}return{vertices:n,tangents:r,faces:i,centre:[l[0],l[1],l[2]],radius:u,width:d,halfHeight:(c[2]-s[2])/2}}var ka={glsl:{title:`GLSL`,suffix:`.glsl`},wgsl:{title:`WGSL`,suffix:`.wgsl`},hlsl:{title:`HLSL`,suffix:`.hlsl`},slang:{title:`Slang`,suffix:`.slang`},osl:{title:`OSL`,suffix:`.osl`},python:{title:`NumPy`,suffix:`-numpy.py`}};async function Aa(e,t=1){let n=`shaders/${t===1?``:`anisotropic/`}${e}.txt`,r=await Ct(n);if(r===null)throw new B(`The shader code is missing beside the page (${n}).`);return new TextDecoder().decode(r)}function ja(e,{latents:t},n=0){let r=t.length/3,i=n*Math.PI/180;return Na(e,(e,n)=>Fa(t[n*r+e])).replace(/\bcode_tangent_x\b/,Fa(Math.fround(Math.cos(i)))).replace(/\bcode_tangent_y\b/,Fa(Math.fround(Math.sin(i))))}function Ma(e,{numbers:t}){return Na(e,(e,n)=>Pa(t[e][n]))}function Na(e,t){return e.replace(/\bcode_(\d+)_(red|green|blue)\b/g,(e,n,r)=>t(Number(n),Un.indexOf(r)))}function Pa({lowest:e,step:t,high:n,low:r}){let i=(e,t)=>` + stored[${e}] * ${Fa(t)}`,a=Fa(e);return n<0?a:r<0?a+i(n,255*t):a+i(n,65280*t)+i(r,255*t)}function Fa(e){for(let t=1;t<9;t++){let n=Number(e.toPrecision(t));if(Math.fround(n)===Math.fround(e))return Ia(n)}return Ia(Number(e.toPrecision(9)))}function Ia(e){let t=String(e);return/^-?\d+$/.test(t)?`${t}.0`:t}function La(e){let[t,n]=[new Float64Array(e),new Float64Array(e)];return t.forEach((r,i)=>{let a=Math.cos(Math.PI*(i+.75)/(e+.5));for(let t=0;t<8;t++){let[t,r]=[1,a];for(let n=2;n<=e;n++)[t,r]=[r,((2*n-1)*a*r-(n-1)*t)/n];let o=e*(a*r-t)/(a*a-1);a-=r/o,n[i]=2/((1-a*a)*o*o)}t[i]=a}),{nodes:t,weights:n}}var{nodes:Ra,weights:za}=La(4);function Ba([e,t]){return Array.from({length:e*t},(n,r)=>{let i=Math.floor(r/e),a=(i+.5)/t;return{u1:.5*((r%e+(i*.6180339887498949+.5)%1)/e),u2:1-a*a,weight:2*a/(e*t)}})}var[Va,Ha]=[Ba(Xn.COARSE),Ba(Xn.FINE)],Ua=Xn.COSINES-1;Xn.TOTAL_CELLS/Ua;function Wa(e,t){let n=typeof e==`number`?e:e[t];return Math.fround(n??NaN)+0}function Ga(e,t){return{alpha:Wa(e.alpha,t),alphaV:Wa(e.alphaV??e.alpha,t),eta:Wa(e.eta,t),albedo:Wa(e.albedo,t),sigmaT:Wa(e.sigmaT,t),g:Wa(e.g,t)}}var{nodes:Ka,weights:qa}=La(8),{MARGIN:Ja,LEAST_ALBEDO:Ya,LEAST_REST:Xa,NO_FACTOR:Za,ROUNDS:Qa,ROUGH_GAIN:$a}=nr;1-Ja;var{COSINES:eo,AZIMUTHS:to,NODES:no}=tr;Array.from({length:nr.FACETS},(e,t)=>({u1:t*.6180339887498949%1,u2:(t+.5)/nr.FACETS}));function ro(e,{azimuths:t,cosines:n}){let r=(e%n+.5)/n,i=Math.sqrt(1-r*r),a=.5*Math.PI*Math.floor(e/n)/Math.max(t-1,1);return{x:i*Math.cos(a),y:i*Math.sin(a),z:r}}var io=[.8191725133961644,.671043606703789,.5497004779019702];function ao(e,t){let n=n=>{let r=t[n]+e*io[n];return r-Math.floor(r)};return[n(0),n(1),n(2)]}var{POLAR_NODES:oo,EDGE_NODES:so,AZIMUTH_NODES:co,MIN_TANGENT:lo}=Qn,[uo,fo]=Yn.TRAINED_G,{DEEPEST:po}=rr;function mo(e){let t={alpha:Yn.MIN_ALPHA,alphaV:Yn.MIN_ALPHA},n=e.eta===1?{...e,...t}:e,r=Math.min(Math.max(n.g,uo),fo);if(r===n.g&&n.sigmaT<=po)return n;let i=n.sigmaT*(1-n.albedo),a=n.sigmaT*n.albedo*(1-n.g);if(i+a/(1-r)>po){let e=1-a/Math.max(po-i,1e-6);r=Math.min(Math.max(e,Math.min(r,0)),r)}let o=a/(1-r),s=i+o,c=s>0?o/s:n.albedo;return{...n,albedo:c,sigmaT:Math.min(s,po),g:r}}var{WI:ho,WO:go}=Zn,_o=[`layer`,`f`,`albedo`,`table`,`basisTexels`],vo=class{port;promised=new Map;count=0;constructor(e){this.port=e,e.addEventListener(`message`,({data:e})=>{let t=this.promised.get(e.id);if(this.promised.delete(e.id),`result`in e)return t?.resolve(e.result);let{name:n,message:r}=e.error;t?.reject(n===`FileError`?new Dt(r):Error(r))})}call(e,t,n=[]){let r=this.count++;return new Promise((i,a)=>{this.promised.set(r,{resolve:i,reject:a}),this.port.postMessage({id:r,name:e,args:t},n)})}},yo=`weights.safetensors`,bo=`anisotropic.safetensors`,xo=10;function So(e){let t=null;return()=>(t??=e().catch(e=>{throw t=null,e}),t)}var Co=class{isotropic;anisotropic=So(()=>To(bo));constructor(e){this.isotropic=e}async material({stack:e,table:t}){let n=Nr(e)?await this.anisotropicFor(e):this.isotropic,r=await n.layer(e);return{core:n,material:{...r,table:t??r.table}}}anisotropicFor({bottom:e,coats:t}){if(t.length>0&&[e,...t].some(e=>jr(e)>xo))throw new B(`The two widths of a surface differ by more than a factor of ${xo}, which the networks cannot layer; give closer widths.`);if(e.kind===`codes`&&e.widths!==2)throw new B(`The loaded material is isotropic; give its coats one width, or coat it in Python.`);return this.anisotropic()}};async function wo(e,t,n=[],r){let{worker:i,broken:a}=await wt(`files`),o=new Promise((e,t)=>{r?.addEventListener(`abort`,()=>t(new _t))});try{if(r?.aborted)throw new _t;let s=new vo(i).call(e,t,n);return await Promise.race([s,a,o])}finally{i.terminate()}}async function To(e=yo){let t=Ct(e),{worker:n,broken:r}=await wt(`core`),i=new vo(n),a=async()=>{let n=await t;if(n===null)throw new B(`The networks are missing beside the page (${e}).`);let r=_o.map(e=>[e,(...t)=>i.call(e,t)]),a=await i.call(`load`,[n.buffer],[n.buffer]);return{...Object.fromEntries(r),...a}};try{return await Promise.race([a(),r])}catch(e){throw n.terminate(),e}}var Eo=class{all=R(new Map);get(e){return this.all.value.get(e)}keep(e,t){return this.all.value=new Map(this.all.peek()).set(e,t),e}},Do=new Eo,Oo=new Eo,ko=new Eo,Ao=new Eo;function jo(e){return`The ${e} is no part of the address or the state; open its file again.`}async function Mo(e,t){let n=Pn(new At(e),e,t),r=Ma(await Aa(`glsl`),n);return Do.keep(n.id,{texture:n,shader:r,basis:await t.basisTexels()})}function No(e){return Oo.keep(kn(Po(e)),e)}function Po(e){return new Uint8Array(Uint16Array.from(e,Et).buffer)}function Fo(e){let t=2*Zi/e.length,n=new Uint16Array(e.buffer),r=Float32Array.from({length:Zi},(e,r)=>Tt(n[Math.floor(r/t)]));if(t!==1&&t!==3||!r.every(Number.isFinite))throw new B(`The table of the material is damaged.`);return r}var Io=Bn(`file`);function Lo(e,t){J({object:`own`,mesh:ko.keep(Io(e),t)})}function Ro(e,t){let n=Ao.keep(Io(e),t),{environment:r,panorama:i}=K.peek();(r!==`own`||i!==n)&&J({environment:`own`,panorama:n})}var zo=new Map;function Bo({object:e,mesh:t}){let n=e===`own`?ko.get(t):void 0;if(n!==void 0)return{mesh:n,isMissing:!1};let r=e===`own`?`goblet`:e,i=zo.get(r)??ua(r);return zo.set(r,i),{mesh:i,isMissing:e===`own`}}function Vo({environment:e,panorama:t}){return e===`own`?Ao.get(t)??null:null}var Ho=new WeakMap;function Uo(e){let t=Ho.get(e);if(t===void 0){let{vertices:n,faces:r}=e,i=[n,8,r,ca(e)];t=So(()=>wo(`occlusion`,[...i])),Ho.set(e,t)}return t()}var Wo=3;function Go(e,{latentSize:t,widths:n,fingerprint:r}){let{kind:i,weights:a,beside_lobe:o,rotation:s=0}=e.description;if(i!==`material`)throw new B(`It is no material that Urushi has saved.`);if(a!==r)throw new B(`It was made with other networks; encode the material again.`);let[c=0]=e.shapeOf(`latents`),l=e.numbers(`latents`,[c===1?1:3,t]),u={kind:`codes`,latents:Float32Array.from(c===1?[...l,...l,...l]:l)};if(n===1){let t=e.shapeOf(`table`);if(t.length===0)return{bottom:u};let n=No(Fo(e.bytes(`table`,`F16`,t)));return{bottom:{...u,table:n,besideLobe:o===!0}}}if(typeof s!=`number`||!Number.isFinite(s))throw new B(`The material's rotation is damaged.`);return{bottom:{...u,widths:n},rotation:Kr(s)}}function Ko({latents:e,table:t},{latentSize:n,widths:r,fingerprint:i},a=0){let o=t?.isOfCodes?void 0:t,s=r===2&&a!==0?{rotation:a}:{},c=o===void 0?{}:{beside_lobe:o.besideLobe},l={kind:`material`,version:Wo,weights:i,...s,...c},u=new Uint8Array(e.slice().buffer),d={latents:{dtype:`F32`,shape:[3,n],bytes:u}};return o!==void 0&&(d.table={dtype:`F16`,shape:[...er.SHAPE,3],bytes:Po(o.logs)}),jt(l,d)}var qo=`#version 300 es
// One triangle over the whole viewport, at the far plane.
out vec2 place;

void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    place = corner;
    gl_Position = vec4(corner, 1.0, 1.0);
}
`,Jo=class extends B{};function Yo(e){let t=e.getContext(`webgl2`,{antialias:!1,depth:!1,preserveDrawingBuffer:!0,powerPreference:`high-performance`});if(t===null)throw new Jo(`This browser offers no WebGL 2, which the picture needs; the cards and plots work without.`);if(!t.getExtension(`EXT_color_buffer_float`))throw new Jo(`This graphics driver cannot draw into float textures, which the picture needs; the cards and plots work without.`);return t.getExtension(`OES_texture_float_linear`),t.getExtension(`EXT_float_blend`),t}var Z=class{gl;program;setters=new Map;constructor(e,t,n={},r=qo){this.gl=e;let i=Object.entries(n).map(([e,t])=>`#define ${e} ${t.toFixed(6)}\n`);this.program=e.createProgram();for(let[n,a]of[[e.VERTEX_SHADER,r],[e.FRAGMENT_SHADER,t.replace(/^(#version .*\n)/,`$1${i.join(``)}`)]]){let t=e.createShader(n);e.shaderSource(t,a),e.compileShader(t),e.attachShader(this.program,t),e.deleteShader(t)}if(e.linkProgram(this.program),!e.isContextLost()){if(!e.getProgramParameter(this.program,e.LINK_STATUS))throw new Jo(`The graphics driver refused a shader: ${e.getAttachedShaders(this.program).map(t=>e.getShaderInfoLog(t)).join(` `)}${e.getProgramInfoLog(this.program)}`);this.findUniforms()}}delete(){this.gl.deleteProgram(this.program)}use(e={}){this.gl.useProgram(this.program);for(let[t,n]of Object.entries(e))this.setters.get(t)?.(n)}cover(e={}){this.use(e),this.gl.drawArrays(this.gl.TRIANGLES,0,3)}findUniforms(){let{gl:e,program:t}=this,n={[e.SAMPLER_2D]:e.TEXTURE_2D,[e.SAMPLER_3D]:e.TEXTURE_3D,[e.SAMPLER_CUBE]:e.TEXTURE_CUBE_MAP,[e.SAMPLER_2D_ARRAY]:e.TEXTURE_2D_ARRAY},r={[e.FLOAT_VEC2]:(t,n)=>e.uniform2fv(t,n),[e.FLOAT_VEC3]:(t,n)=>e.uniform3fv(t,n),[e.FLOAT_VEC4]:(t,n)=>e.uniform4fv(t,n),[e.FLOAT_MAT3x2]:(t,n)=>e.uniformMatrix3x2fv(t,!1,n),[e.FLOAT_MAT3]:(t,n)=>e.uniformMatrix3fv(t,!1,n),[e.FLOAT_MAT4]:(t,n)=>e.uniformMatrix4fv(t,!1,n),[e.FLOAT]:(t,n)=>e.uniform1f(t,Number(n))};e.useProgram(t);let i=0;for(let a=e.getProgramParameter(t,e.ACTIVE_UNIFORMS)-1;a>=0;a--){let{name:o,type:s}=e.getActiveUniform(t,a),c=e.getUniformLocation(t,o),[l,u]=[n[s],i];l&&e.uniform1i(c,i++),this.setters.set(o.replace(`[0]`,``),t=>{l?(e.activeTexture(e.TEXTURE0+u),e.bindTexture(l,t)):r[s]?r[s](c,t):e.uniform1i(c,Number(t))})}}};function Xo(e,t){return e.replace(/^#include (\S+)$/gm,(e,n)=>t[n])}function Zo(e,t,n,r,i){e.texParameteri(t,e.TEXTURE_MIN_FILTER,n),e.texParameteri(t,e.TEXTURE_MAG_FILTER,r),e.texParameteri(t,e.TEXTURE_WRAP_S,i),e.texParameteri(t,e.TEXTURE_WRAP_T,i),e.texParameteri(t,e.TEXTURE_WRAP_R,i)}var Qo=class{gl;width;height;textures=[];frame;buffers=[];constructor(e,t,n,r,{filter:i=e.LINEAR,samples:a=0,hasDepth:o=!1}={}){this.gl=e,this.width=t,this.height=n,this.frame=e.createFramebuffer(),e.bindFramebuffer(e.FRAMEBUFFER,this.frame);let s=(r,i)=>{let o=e.createRenderbuffer();e.bindRenderbuffer(e.RENDERBUFFER,o),e.renderbufferStorageMultisample(e.RENDERBUFFER,a,r,t,n),e.framebufferRenderbuffer(e.FRAMEBUFFER,i,e.RENDERBUFFER,o),this.buffers.push(o)},c=r.map((t,n)=>e.COLOR_ATTACHMENT0+n);for(let[o,l]of r.entries()){if(a>0){s(l,c[o]);continue}let r=e.createTexture();e.bindTexture(e.TEXTURE_2D,r),e.texStorage2D(e.TEXTURE_2D,1,l,t,n),Zo(e,e.TEXTURE_2D,i,i,e.CLAMP_TO_EDGE),e.framebufferTexture2D(e.FRAMEBUFFER,c[o],e.TEXTURE_2D,r,0),this.textures.push(r)}o&&s(e.DEPTH_COMPONENT24,e.DEPTH_ATTACHMENT),e.drawBuffers(c),e.bindFramebuffer(e.FRAMEBUFFER,null)}bind(){this.gl.bindFramebuffer(this.gl.FRAMEBUFFER,this.frame),this.gl.viewport(0,0,this.width,this.height)}read(e=this.width){let{gl:t,height:n}=this;t.bindFramebuffer(t.FRAMEBUFFER,this.frame);let r=new Float32Array(4*e*n);return t.readPixels(0,0,e,n,t.RGBA,t.FLOAT,r),t.bindFramebuffer(t.FRAMEBUFFER,null),r.filter((e,t)=>t%4<3)}delete(){let{gl:e}=this;e.deleteFramebuffer(this.frame);for(let t of this.textures)e.deleteTexture(t);for(let t of this.buffers)e.deleteRenderbuffer(t)}},$o=`#version 300 es
// A level of the environment from the next finer one: sixteen texels with binomial weights.
precision highp float;
precision highp samplerCube;

uniform samplerCube environment; // its base level is the finer one
uniform mat3 face; // to a direction from place on the face
uniform float side; // texels along a side of the finer level

in vec2 place;
out vec4 colour;

void main() {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 4; k++) {
            vec2 at = place + (vec2(float(i), float(k)) - 1.5) * (2.0 / side);
            float weight = (i == 1 || i == 2 ? 3.0 : 1.0) * (k == 1 || k == 2 ? 3.0 : 1.0)
                * pow(1.0 + dot(at, at), -1.5);
            sum += vec4(textureLod(environment, face * vec3(at, 1.0), 0.0).rgb, 1.0) * weight;
        }
    }
    colour = vec4(sum.rgb / sum.a, 1.0);
}
`,es=`#version 300 es
// Irradiance over pi by the normal: the mean of the environment, weighted by the cosine.
precision highp float;
precision highp samplerCube;

uniform samplerCube environment;
uniform mat3 face; // to a direction from place on the face
uniform float level; // of the environment whose texels are summed
uniform float side; // texels along a side of that level

in vec2 place;
out vec4 colour;

void main() {
    vec3 normal = normalize(face * vec3(place, 1.0));
    vec4 sum = vec4(0.0);
    for (float y = 1.0 / side - 1.0; y < 1.0; y += 2.0 / side) {
        for (float x = 1.0 / side - 1.0; x < 1.0; x += 2.0 / side) {
            vec3 texel = vec3(x, y, 1.0);
            float solidAngle = pow(dot(texel, texel), -1.5);
            texel = normalize(texel);
            for (int axis = 0; axis < 6; axis++) {
                vec3 light = axis % 3 == 0 ? texel.zxy : axis % 3 == 1 ? texel.yzx : texel;
                light = axis < 3 ? light : -light;
                float weight = max(dot(normal, light), 0.0) * solidAngle;
                sum += vec4(textureLod(environment, light, level).rgb, 1.0) * weight;
            }
        }
    }
    colour = vec4(sum.rgb / sum.a, 1.0);
}
`,ts=`#version 300 es
// A face of the environment from a panorama, as Mitsuba turns it: the first row is the zenith, the
// first column +y, and a quarter on is +x.
precision highp float;

uniform sampler2D panorama;
uniform mat3 face;

in vec2 place;
out vec4 colour;

void main() {
    vec3 direction = normalize(face * vec3(place, 1.0));
    vec2 at = vec2(atan(direction.x, direction.y) / 6.28318531,
                   acos(clamp(direction.z, -1.0, 1.0)) / 3.14159265);
    colour = vec4(textureLod(panorama, at, 0.0).rgb, 1.0);
}
`,ns=`#version 300 es
// Three environments by formula: a studio, a sky and a room. Radiance without the bright lights.
precision highp float;

uniform mat3 face;
uniform bool isPanorama; // place is that in a panorama as Mitsuba turns it, not that on a face
uniform int which;

in vec2 place;
out vec4 colour;

const float PI = 3.14159265;

// 1 inside a rectangle around \`centre\` as seen from the origin, with soft edges.
float panel(vec3 direction, vec3 centre, vec2 half_, float tilt, float soft) {
    vec3 axis = normalize(centre);
    vec3 right = normalize(cross(vec3(0.0, 0.0, 1.0), axis));
    vec3 up = cross(axis, right);
    float ahead = dot(direction, axis);
    if (ahead <= 0.0) {
        return 0.0;
    }
    vec2 at = vec2(dot(direction, right), dot(direction, up)) * length(centre) / ahead;
    at = mat2(cos(tilt), sin(tilt), -sin(tilt), cos(tilt)) * at;
    vec2 inside = smoothstep(half_ + soft, half_ - soft, abs(at));
    return inside.x * inside.y;
}

// A black studio: a large soft key in front, brighter at its lower edge, a fill beside the camera, one
// above, strips behind at both sides, and a pool of light on the floor. The black beside them shows the
// contours of metals.
vec3 studio(vec3 d) {
    vec3 light = mix(vec3(0.04), vec3(0.02), smoothstep(0.0, 0.7, d.z));
    float key = panel(d, vec3(-0.7, -3.0, 1.2), vec2(1.9, 1.5), 0.0, 0.3);
    light += vec3(15.0, 14.9, 14.6) * key * mix(1.0, 0.65, smoothstep(0.1, 0.8, d.z));
    light += vec3(1.5, 1.52, 1.56) * panel(d, vec3(2.2, -2.6, 0.9), vec2(0.8, 1.3), 0.0, 0.5);
    light += vec3(3.0, 3.0, 3.0) * panel(d, vec3(0.3, 0.8, 3.2), vec2(1.5, 0.7), 0.0, 0.4);
    light += vec3(6.2, 6.4, 6.8) * panel(d, vec3(3.4, 1.6, 1.3), vec2(0.4, 1.8), 0.0, 0.2);
    light += vec3(4.6, 4.5, 4.3) * panel(d, vec3(-3.4, 1.5, 1.1), vec2(0.3, 1.7), 0.0, 0.2);
    vec2 at = d.xy / max(-d.z, 1e-3) + vec2(0.1, 0.8);
    vec3 floor_ = vec3(0.03) + vec3(1.25, 1.24, 1.22) / (1.0 + 0.7 * dot(at, at));
    return mix(light, floor_, smoothstep(0.0, -0.08, d.z));
}

// Smooth noise in [0, 1]: a random number at each corner of a grid (Perlin 1985, by values).
float noise(vec2 at) {
    vec2 cell = floor(at), part = smoothstep(0.0, 1.0, at - cell);
    vec4 corners;
    for (int k = 0; k < 4; k++) {
        vec2 corner = cell + vec2(float(k % 2), float(k / 2));
        corners[k] = fract(52.9829189 * fract(dot(corner, vec2(0.06711056, 0.00583715))));
    }
    vec2 rows = mix(corners.xz, corners.yw, part.x);
    return mix(rows.x, rows.y, part.y);
}

// Octaves of noise.
float cloudy(vec2 at) {
    float sum = 0.0, share = 0.5;
    for (int octave = 0; octave < 6; octave++) {
        sum += share * noise(at);
        at = mat2(1.6, 1.2, -1.2, 1.6) * at + 7.3;
        share *= 0.5;
    }
    return sum;
}

// A summer's sky with clouds over trees and a meadow, seen from a terrace.
vec3 sky(vec3 d) {
    vec3 sun = normalize(vec3(-0.50, -0.62, 0.60));
    float near = max(dot(d, sun), 0.0);
    float height = max(d.z, 0.0);
    vec3 light = mix(vec3(0.98, 1.06, 1.14), vec3(0.13, 0.29, 0.72), pow(height, 0.42));
    light += vec3(1.0, 0.85, 0.62) * (0.30 * pow(near, 8.0) + 1.6 * pow(near, 90.0));
    vec2 over = 1.3 * d.xy / (height + 0.22);
    float thick = cloudy(over);
    float cloud = smoothstep(0.46, 0.66, thick) * smoothstep(0.02, 0.2, d.z);
    float lit = smoothstep(0.10, -0.10, cloudy(over + 0.25 * sun.xy) - thick); // thinner to the sun
    light = mix(light, mix(vec3(0.66, 0.70, 0.78), vec3(2.0, 1.92, 1.8), lit), cloud);
    float way = atan(d.y, d.x);
    vec2 around = vec2(cos(way), sin(way));
    float trees = 0.035 + 0.09 * cloudy(4.0 * around + 3.0) + 0.02 * noise(60.0 * around);
    vec3 leaves = mix(vec3(0.05, 0.075, 0.035), vec3(0.13, 0.16, 0.06), noise(25.0 * vec2(way, 3.0 * d.z)));
    light = mix(light, leaves, smoothstep(0.004, -0.004, d.z - trees));
    vec2 at = 1.7 * d.xy / max(-d.z, 1e-3);
    vec3 ground = mix(vec3(0.13, 0.17, 0.055), vec3(0.22, 0.26, 0.10), noise(0.5 * at));
    vec2 joint = abs(fract(at / 1.4) - 0.5) * 1.4;
    float joints = smoothstep(0.66, 0.69, max(joint.x, joint.y)) * smoothstep(-0.15, -0.5, d.z);
    float stone = 0.85 + 0.3 * noise(floor(at / 1.4) + 0.5) * (0.7 + 0.3 * noise(9.0 * at));
    vec3 terrace = vec3(0.50, 0.47, 0.42) * stone * (1.0 - 0.5 * joints);
    float edge = max(abs(at.x), abs(at.y));
    ground = mix(ground, terrace, smoothstep(5.65, 5.55, edge));
    return mix(ground, light, smoothstep(-0.004, 0.004, d.z));
}

// A room with windows behind and on the left, seen from a table in it.
vec3 room(vec3 d) {
    vec3 low = vec3(-3.2, -2.6, -0.9), high = vec3(2.6, 2.8, 1.9);
    vec3 far = mix(low, high, step(0.0, d)) / (abs(d) + 1e-6) * sign(d);
    float away = min(far.x, min(far.y, far.z));
    vec3 at = d * away;
    vec3 light;
    if (away == far.z && d.z < 0.0) { // wooden floor
        float board = floor(at.y / 0.28);
        float shade = 0.85 + 0.15 * sin(board * 7.3) + 0.05 * sin(at.x * 9.0 + board * 3.0);
        light = vec3(0.40, 0.26, 0.165) * shade * (0.7 + 0.6 * smoothstep(-2.6, 2.6, at.y));
    } else if (away == far.z) { // ceiling
        light = vec3(0.95, 0.92, 0.87) * (0.7 + 0.3 * smoothstep(-2.6, 2.8, at.y));
    } else {
        light = vec3(0.58, 0.53, 0.465) * (0.8 + 0.2 * smoothstep(-2.6, 2.8, at.y));
        light *= 0.7 + 0.3 * smoothstep(-0.9, -0.3, at.z);
        light = mix(light, vec3(0.34, 0.31, 0.28), smoothstep(-0.72, -0.735, at.z)); // skirting
    }
    if (away == far.y && d.y > 0.0) { // windows
        float column = abs(abs(at.x + 0.3) - 1.15);
        float open = smoothstep(0.62, 0.59, column) * smoothstep(0.92, 0.89, abs(at.z - 0.55));
        float frame = smoothstep(0.03, 0.045, column) * smoothstep(0.03, 0.045, abs(at.z - 0.75));
        float trees = 0.35 + 0.9 * cloudy(vec2(1.7 * at.x, 0.0));
        vec3 leaves = mix(vec3(0.35, 0.5, 0.2), vec3(0.85, 1.0, 0.5), noise(vec2(14.0 * at.x, 14.0 * at.z)));
        vec3 outside = mix(leaves, vec3(3.0, 3.4, 3.9), smoothstep(-0.06, 0.06, at.z - trees));
        light = mix(light, outside, open * frame);
        float curtain = smoothstep(0.62, 0.66, column) * smoothstep(0.86, 0.82, column);
        vec3 cloth = vec3(1.05, 1.0, 0.9) * (0.75 + 0.25 * sin(55.0 * at.x));
        light = mix(light, cloth, curtain);
    }
    if (away == far.x && d.x > 0.0) { // a lamp beside
        float lamp = smoothstep(0.34, 0.26, length(vec2(at.y + 1.3, (at.z - 0.35) * 1.1)));
        light = mix(light, vec3(5.5, 4.0, 2.4), lamp);
    }
    if (away == far.x && d.x < 0.0) { // a wide window with four panes
        vec2 pane = abs(vec2(at.y + 0.7, at.z - 0.65));
        float open = smoothstep(1.62, 1.55, pane.x) * smoothstep(1.02, 0.95, pane.y);
        float frame = smoothstep(0.03, 0.06, pane.x) * smoothstep(0.03, 0.06, pane.y);
        light = mix(light, vec3(7.6, 8.0, 8.6), open * frame);
    }
    return 2.0 * light; // as bright on a white object as the sky
}

void main() {
    vec3 direction = normalize(face * vec3(place, 1.0));
    if (isPanorama) {
        float phi = PI * (place.x + 1.0), theta = 0.5 * PI * (place.y + 1.0);
        direction = vec3(sin(theta) * sin(phi), sin(theta) * cos(phi), cos(theta));
    }
    vec3 light = which == 0 ? studio(direction) : which == 1 ? sky(direction) : room(direction);
    colour = vec4(light, 1.0);
}
`,rs=Math.log2(256)+1,is=16,as=Math.log2(256/is),os=[[0,0,-1,0,-1,0,1,0,0],[0,0,1,0,-1,0,-1,0,0],[1,0,0,0,0,1,0,1,0],[1,0,0,0,0,-1,0,-1,0],[1,0,0,0,-1,0,0,0,1],[-1,0,0,0,-1,0,0,0,-1]],ss=[`studio`,`sky`,`room`],cs={direction:sa([-.5,-.62,.6]),power:[3.4,3.05,2.55]};function ls(e){return e===`sky`?[cs]:[]}var us=e=>Math.max(ss.indexOf(e),0),ds=class{gl;texture;irradiance;convolve;frame;halve;places;panorama;constructor(e,t){this.gl=e;let n=t?e.LINEAR_MIPMAP_NEAREST:e.LINEAR_MIPMAP_LINEAR;this.texture=fs(e,rs,256,n),this.irradiance=fs(e,1,is,e.LINEAR),this.convolve=new Z(e,es),this.frame=e.createFramebuffer(),this.halve=new Z(e,$o),this.places=new Z(e,ns),this.panorama=new Z(e,ts)}drawFormula(e){this.places.use({which:us(e),isPanorama:!1}),this.drawFaces(this.places,this.texture,256,0),this.drawLevels()}panoramaOf(e){let{gl:t}=this,n=new Qo(t,1024,512,[t.RGBA32F]);n.bind(),this.places.cover({which:us(e),isPanorama:!0});let r=n.read();return n.delete(),{width:n.width,height:n.height,pixels:r}}drawPanorama(e){let{gl:t}=this,n=t.createTexture();t.bindTexture(t.TEXTURE_2D,n);let{width:r,height:i,pixels:a}=e;t.texImage2D(t.TEXTURE_2D,0,t.RGB16F,r,i,0,t.RGB,t.FLOAT,a),Zo(t,t.TEXTURE_2D,t.LINEAR,t.LINEAR,t.CLAMP_TO_EDGE),t.texParameteri(t.TEXTURE_2D,t.TEXTURE_WRAP_S,t.REPEAT),this.panorama.use({panorama:n}),this.drawFaces(this.panorama,this.texture,256,0),this.drawLevels(),t.deleteTexture(n)}drawLevels(){let{gl:e,halve:t,convolve:n,texture:r}=this;for(let n=1;n<rs;n++)t.use({environment:r,side:256>>n-1}),e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_BASE_LEVEL,n-1),e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_MAX_LEVEL,n-1),this.drawFaces(t,r,256>>n,n);e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_BASE_LEVEL,0),e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_MAX_LEVEL,rs-1),n.use({environment:r,level:as,side:is}),this.drawFaces(n,this.irradiance,is,0)}drawFaces(e,t,n,r){let{gl:i}=this;i.bindFramebuffer(i.FRAMEBUFFER,this.frame),i.viewport(0,0,n,n),os.forEach((n,a)=>{let o=i.TEXTURE_CUBE_MAP_POSITIVE_X+a;i.framebufferTexture2D(i.FRAMEBUFFER,i.COLOR_ATTACHMENT0,o,t,r),e.cover({face:n})}),i.bindFramebuffer(i.FRAMEBUFFER,null)}};function fs(e,t,n,r){let i=e.createTexture();return e.bindTexture(e.TEXTURE_CUBE_MAP,i),e.texStorage2D(e.TEXTURE_CUBE_MAP,t,e.RGBA16F,n,n),Zo(e,e.TEXTURE_CUBE_MAP,r,e.LINEAR,e.CLAMP_TO_EDGE),i}var ps=128,ms={1:{azimuths:1,cosines:32,samples:ps},2:{azimuths:8,cosines:16,samples:ps}},hs=Float32Array.from({length:16},(e,t)=>5.9*t),gs=hs.map(e=>Math.cos(e*Math.PI/180)),_s=Float32Array.from({length:241},(e,t)=>(t-120)*.745),vs=200,ys=class e{cores;page;generation=0;tables=[];texture=null;plane=R(null);albedo=R(null);widths=1;rotation=0;core;material=null;albedoIsOld=!0;timer=0;wanted=null;latest=null;busy=!1;key=``;constructor(e,t){this.cores=e,this.page=t,this.core=e.isotropic}show(e){let t=`${e.texture?.texture.id??``}${e.rotation}${xs(e.stack)}`;(t!==this.key||e.table?.logs!==this.latest?.table?.logs)&&(this.key=t,this.wanted=this.latest=e,this.work())}async drawPlane(){let{material:e}=this,t=this.page.incidence();if(e===null||t===null)return;this.later();let n=bs(t,this.rotation),r=await this.core.f(e,...n);e===this.material&&(this.plane.value=r)}frozen(){let t=Object.create(e.prototype);return Object.assign(t,this,{tables:[...this.tables],busy:!1})}async another(){let{material:e,generation:t}=this;if(e===null||this.busy||this.tables.length>=48)return!1;let n=await this.table(this.core,e,this.tables.length);return t!==this.generation||this.busy?!1:(this.tables.push(n),!0)}async work(){if(!this.busy){for(this.busy=!0;this.wanted!==null;){let e=this.wanted;this.wanted=null;try{await this.compute(e)}catch(e){if(this.wanted!==null)continue;this.key=``,this.page.failed(e,()=>this.show(this.latest))}}this.busy=!1}}async compute(e){let{core:t,material:n}=await this.cores.material(e),r=await this.table(t,n,0);this.core=t,this.widths=t.widths,this.rotation=e.rotation,this.material=n,this.texture=e.texture,this.generation++,this.tables=[r],this.page.changed(),this.albedoIsOld=!0,await this.drawPlane()}later(){clearTimeout(this.timer);let e=async()=>{let{material:e}=this;if(e===null||!this.albedoIsOld)return;let t=await this.core.albedo(e,gs);e===this.material&&(this.albedo.value=t,this.albedoIsOld=!1)};this.timer=setTimeout(()=>e().catch(this.page.failed),vs)}table(e,t,n){let r=ao(ps*n,[0,0,0]);return e.table(t,{...ms[e.widths],shift:r})}};function bs(e,t){let n=e*Math.PI/180,r=t*Math.PI/180,[i,a]=[Math.cos(r),-Math.sin(r)],o=new Float32Array(3*_s.length),s=new Float32Array(3*_s.length);return _s.forEach((e,t)=>{let r=e*Math.PI/180;o.set([-Math.sin(n)*i,-Math.sin(n)*a,Math.cos(n)],3*t),s.set([Math.sin(r)*i,Math.sin(r)*a,Math.cos(r)],3*t)}),[o,s]}function xs(e){return JSON.stringify(e,(e,t)=>t instanceof Float32Array?Array.from(t):t)}var Ss=25,Cs=60,ws=160,Ts={card:60,software:3e3},[Es,Ds]=[3,6],Os=5e5,ks=3,As=32,js=[[1,1],[.75,1],[.5,1],[.5,.5],[.25,.5],[.25,.25]],Ms=class{slots;failed;gathered=R(0);converged=R(!1);difference=R(null);ready=Promise.resolve();renderer=null;shot=null;cost={moving:0,resting:0};slow=!1;changedAt=-1/0;dirty=!0;running=!1;wake=()=>{};count=0;resting=!1;uploaded=[``,``];constructor(e,t){this.slots=e,this.failed=t}setRenderer(e){this.renderer=e,this.uploaded.fill(``),this.slow=e?.isSoftware??!1;let t=this.slow?Ts.software:Ts.card;Object.assign(this.cost,{moving:t,resting:t}),this.refresh()}setShot(e){let{shot:t,renderer:n}=this;this.shot=e,t!==null&&this.count>0&&Ps(t)===Ps(e)&&n!==null?(n.show(e),this.measure(n,e)):this.refresh()}measure(e,t){this.difference.value=t.comparison===`difference`?e.difference(t):null}async whole(){for(;this.count===0&&this.running;)await new Promise(requestAnimationFrame);if(this.renderer===null||this.count===0)throw Ns();return this.renderer}refresh(){this.dirty=!0,this.changedAt=performance.now(),this.count=0,this.resting=!1,this.gathered.value=0,this.converged.value=!1,this.wake(),this.run()}async run(){if(!this.running){this.running=!0;try{for(await null;await this.step();)await new Promise(requestAnimationFrame)}catch(e){this.failed(e)}finally{this.running=!1}}}async step(){let{renderer:e,shot:t}=this;if(e===null||t===null)return!1;let n=Fs(t);if(n.some(e=>this.slots[e].tables.length===0))return!1;if(this.dirty)return this.dirty=!1,await this.preview(e,t,n),!0;let r=this.changedAt+ws-performance.now();return r>0?(await new Promise(e=>{this.wake=e,setTimeout(e,r)}),!0):this.rest(e,t,n)}async rest(e,t,n){if(!this.resting){if(await this.ready,this.dirty)return!0;this.resting=!0,this.count=0}let{frames:r}=this.plan(e,t);if(this.count>=r)return this.converged.value=!0,!1;for(let e of n)if(this.slots[e].texture===null&&this.slots[e].tables.length<=this.count&&(!await this.slots[e].another()||!this.resting))return!0;return await this.improve(e,t,n)&&(this.count++,this.gathered.value=this.count/r),!0}plan(e,t){let n=Fs(t).every(e=>this.slots[e].texture!==null),r=n?ks*48:48;if(!this.slow)return{frames:r,scale:1};let i=Os/e.pixels(t),a=n||t.part?Ds:Es,o=Math.min(Math.max(Math.round(i),a),r);return{frames:o,scale:t.part?1:Math.min(Math.sqrt(i/o),1)}}async preview(e,t,n){let r=e.pixels(t)/1e6,[i,a]=js.find(([e,t])=>this.cost.moving*r*e**2*t<Ss)??js.at(-1);for(let t of n)this.upload(e,t,null);e.draw(t,i,a),this.learn(`moving`,await e.finished(),r*i**2*a)}async improve(e,t,n){let{scale:r}=this.plan(e,t),i=e.pixels(t)/1e6*r**2;for(let t of n)this.upload(e,t,this.count);let a=Math.min(Math.max(Math.ceil(this.cost.resting*i/Cs),1),As),o=performance.now(),s=null;for(let n of e.drawFrame(t,this.count,r,1,a)){let t=e.finished();if(await s,!this.resting)return!1;s=t}return await e.finished(),this.measure(e,t),this.learn(`resting`,performance.now()-o,i),this.resting}learn(e,t,n){this.cost[e]+=(Math.max(t,0)/n-this.cost[e])*.5}upload(e,t,n){let{tables:r,generation:i,material:a,texture:o,widths:s,rotation:c}=this.slots[t],l=e.material(t),u=r[n??0]??r[0],d=`${i}.${n}`;u!==void 0&&this.uploaded[t]!==d&&(l.setTable(u,ms[s],c,n===null),this.uploaded[t]=d),l.setTexels(o),a!==null&&l.setMaterial(a)}};function Ns(){return new B(`There is no picture to save.`)}function Ps({exposure:e,tone:t,background:n,scale:r,...i}){return JSON.stringify([i,n===`environment`])}function Fs(e){return e.comparison===`off`?[e.slot]:[0,1]}var Is=`// Written by \`python -m viewer.formulas\` from the formulas of Python. Do not edit it.

// The share of light that passes the topmost interface, for a direction.
float material_transmittance(float spread, float factor, float eta, float k, float cosine) {
    if (eta >= 1.0) { return 1.0; }
    float index = (k > 0.0 ? 1.0 : eta);
    float thinner = max(min(index, 1.0), 0.001);
    float above = max(cosine, 0.005);
    float critical2 = max(1.0 - thinner * thinner, 0.0);
    float beyond = above - sqrt(critical2);
    float root_beyond = sqrt(beyond * beyond + spread);
    float high_beyond = 0.5 * (abs(beyond) + root_beyond);
    float ramp_beyond = (beyond > 0.0 ? high_beyond : 0.25 * spread / high_beyond);
    float root_all = sqrt(above * above + spread);
    float high_all = 0.5 * (abs(above) + root_all);
    float ramp_all = (above > 0.0 ? high_all : 0.25 * spread / high_all);
    float per_index = 1.0 / (thinner * thinner);
    float straight2 = (above * above - critical2) * per_index;
    float blur2 = 4.0 * spread * critical2 * per_index * per_index + 1.0e-12;
    float root_inside = sqrt(straight2 * straight2 + blur2);
    float high_inside = 0.5 * (abs(straight2) + root_inside);
    float ramp_inside = (straight2 > 0.0 ? high_inside : 0.25 * blur2 / high_inside);
    float inside = sqrt(min(ramp_inside, 1.0));
    float across = above + thinner * inside;
    float along = thinner * above + inside;
    float transmittance = 2.0 * thinner * above * inside * (1.0 / (across * across) + 1.0 / (along *
        along)) * (ramp_beyond * root_all) / (root_beyond * ramp_all);
    return (1.0 > index ? 1.0 - factor * (1.0 - transmittance) : 1.0);
}
// f [1/sr] of a material of one GGX width by its lobe and the table of its rest.
vec3 material_f(vec3 numbers[6], highp sampler3D table, vec3 wi, vec3 wo) {
    // The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where
    // wi + wo stands for the half vector.
    float above_i = max(wi.z, 0.0);
    float above_o = max(wo.z, 0.0);
    float half_x = wi.x + wo.x;
    float half_y = wi.y + wo.y;
    float half_z = above_i + above_o;
    float half_xy2 = half_x * half_x + half_y * half_y;
    float half_z2 = half_z * half_z;
    vec3 alpha2 = numbers[0] * numbers[0];
    vec3 remaining = 1.0 - alpha2;
    vec3 ratio = (half_xy2 + half_z2) / (half_xy2 + alpha2 * half_z2 + 1.0e-18);
    vec3 masking_i = above_i + sqrt(alpha2 + remaining * (above_i * above_i));
    vec3 masking_o = above_o + sqrt(alpha2 + remaining * (above_o * above_o));
    vec3 lobe_shape = alpha2 / 3.1415927 * (ratio * ratio) / (masking_i * masking_o);
    float cos_facet = min(0.5 * sqrt(half_x * half_x + half_y * half_y + half_z * half_z), 1.0);
    // Its Fresnel term at the cosine to the facet.
    float away_facet = 1.0 - cos_facet;
    float away2_facet = away_facet * away_facet;
    float fifth_facet = away2_facet * away2_facet * away_facet;
    float cos2_facet = cos_facet * cos_facet;
    float sin2_facet = 1.0 - cos2_facet;
    vec3 difference_facet = (numbers[4] - 1.0) * (numbers[4] + 1.0) - numbers[5] * numbers[5] +
        cos2_facet;
    vec3 size_facet = sqrt(difference_facet * difference_facet + 4.0 * (numbers[4] * numbers[4]) *
        (numbers[5] * numbers[5]));
    vec3 root_facet = sqrt(0.5 * max(size_facet + difference_facet, vec3(0.0, 0.0, 0.0)));
    vec3 imaginary2_facet = 0.5 * max(size_facet - difference_facet, vec3(0.0, 0.0, 0.0));
    vec3 less_facet = root_facet - cos_facet;
    vec3 more_facet = root_facet + cos_facet;
    vec3 across_facet = (less_facet * less_facet + imaginary2_facet) / (more_facet * more_facet +
        imaginary2_facet);
    vec3 product_facet = root_facet * cos_facet;
    vec3 far_facet = imaginary2_facet * cos2_facet + 1.0e-12;
    vec3 third_facet = product_facet - sin2_facet;
    vec3 fourth_facet = product_facet + sin2_facet;
    vec3 parallel_facet = (third_facet * third_facet + far_facet) / (fourth_facet * fourth_facet +
        far_facet);
    vec3 fresnel_facet = numbers[1] * (1.0 - fifth_facet) + numbers[2] * fifth_facet + numbers[3] *
        (0.5 * across_facet * (1.0 + parallel_facet));
    vec3 lobe = lobe_shape * fresnel_facet;
    // The table's coordinates, from the first node to the last.
    vec3 both = wi + wo;
    vec3 apart = wi - wo;
    float z2 = max(both.z * both.z, 1.0e-18);
    float squared = both.x * both.x + both.y * both.y + z2;
    float cos_d = min(0.5 * sqrt(squared), 1.0);
    float across = both.x * both.x + both.y * both.y;
    float node0 = clamp((log(across / z2 + 1.0e-5) - (-11.512925)) * 0.05428681, 0.0, 1.0) * 95.0;
    float node1 = clamp(sqrt(1.0 - cos_d), 0.0, 1.0) * 31.0;
    float node2 = clamp(1.0 - sqrt(1.0 - min(0.5 * abs(apart.z) / max(min(0.5 * both.z, sqrt(across
        / squared * ((1.0 - cos_d) * (1.0 + cos_d)))), 1.0e-9), 1.0)), 0.0, 1.0) * 7.0;
    float place0 = (node0 + 0.5) * 0.010416667;
    float place1 = (node1 + 0.5) * 0.03125;
    float first = node2 + 0.5;
    vec3 texel0_0_place = vec3(first * 0.125, place1, place0);
    vec4 texel0_0 = textureLod(table, texel0_0_place, 0.0);
    vec3 rest = exp(texel0_0.rgb);
    vec3 spread2_passed_i = max(numbers[0] * numbers[0] * (1.0 - wi.z * wi.z), vec3(1.0e-9, 1.0e-9,
        1.0e-9));
    vec3 passed_i = vec3(material_transmittance(spread2_passed_i.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wi.z), material_transmittance(spread2_passed_i.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wi.z), material_transmittance(spread2_passed_i.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wi.z));
    vec3 spread2_passed_o = max(numbers[0] * numbers[0] * (1.0 - wo.z * wo.z), vec3(1.0e-9, 1.0e-9,
        1.0e-9));
    vec3 passed_o = vec3(material_transmittance(spread2_passed_o.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wo.z), material_transmittance(spread2_passed_o.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wo.z), material_transmittance(spread2_passed_o.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wo.z));
    return lobe + passed_i * passed_o * rest;
}
// f [1/sr] of a material of two GGX widths by its lobe and the table of its rest.
vec3 material_f2(vec3 numbers[7], float stretch, highp sampler3D table, vec3 wi, vec3 wo) {
    // The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where
    // wi + wo stands for the half vector.
    float above_i = max(wi.z, 0.0);
    float above_o = max(wo.z, 0.0);
    float half_x = wi.x + wo.x;
    float half_y = wi.y + wo.y;
    float half_z = above_i + above_o;
    float half_xy2 = half_x * half_x + half_y * half_y;
    float half_z2 = half_z * half_z;
    vec3 alpha2 = numbers[0] * numbers[6];
    vec3 u_over_v = numbers[0] / numbers[6];
    vec3 v_over_u = numbers[6] / numbers[0];
    vec3 ratio = (half_xy2 + half_z2) / (half_x * half_x * v_over_u + half_y * half_y * u_over_v +
        alpha2 * half_z2 + 1.0e-18);
    vec3 masking_i = above_i + sqrt(alpha2 * (wi.x * wi.x * u_over_v + wi.y * wi.y * v_over_u) +
        above_i * above_i);
    vec3 masking_o = above_o + sqrt(alpha2 * (wo.x * wo.x * u_over_v + wo.y * wo.y * v_over_u) +
        above_o * above_o);
    vec3 lobe_shape = alpha2 / 3.1415927 * (ratio * ratio) / (masking_i * masking_o);
    float cos_facet = min(0.5 * sqrt(half_x * half_x + half_y * half_y + half_z * half_z), 1.0);
    // Its Fresnel term at the cosine to the facet.
    float away_facet = 1.0 - cos_facet;
    float away2_facet = away_facet * away_facet;
    float fifth_facet = away2_facet * away2_facet * away_facet;
    float cos2_facet = cos_facet * cos_facet;
    float sin2_facet = 1.0 - cos2_facet;
    vec3 difference_facet = (numbers[4] - 1.0) * (numbers[4] + 1.0) - numbers[5] * numbers[5] +
        cos2_facet;
    vec3 size_facet = sqrt(difference_facet * difference_facet + 4.0 * (numbers[4] * numbers[4]) *
        (numbers[5] * numbers[5]));
    vec3 root_facet = sqrt(0.5 * max(size_facet + difference_facet, vec3(0.0, 0.0, 0.0)));
    vec3 imaginary2_facet = 0.5 * max(size_facet - difference_facet, vec3(0.0, 0.0, 0.0));
    vec3 less_facet = root_facet - cos_facet;
    vec3 more_facet = root_facet + cos_facet;
    vec3 across_facet = (less_facet * less_facet + imaginary2_facet) / (more_facet * more_facet +
        imaginary2_facet);
    vec3 product_facet = root_facet * cos_facet;
    vec3 far_facet = imaginary2_facet * cos2_facet + 1.0e-12;
    vec3 third_facet = product_facet - sin2_facet;
    vec3 fourth_facet = product_facet + sin2_facet;
    vec3 parallel_facet = (third_facet * third_facet + far_facet) / (fourth_facet * fourth_facet +
        far_facet);
    vec3 fresnel_facet = numbers[1] * (1.0 - fifth_facet) + numbers[2] * fifth_facet + numbers[3] *
        (0.5 * across_facet * (1.0 + parallel_facet));
    vec3 lobe = lobe_shape * fresnel_facet;
    // The table's coordinates, from the first node to the last.
    vec3 both = wi + wo;
    vec3 apart = wi - wo;
    float stretched_z2 = max(both.z * both.z, 1.0e-18);
    float stretched_across = both.x * both.x * (stretch * stretch) + both.y * both.y / (stretch *
        stretch);
    float apart_across = apart.x * apart.x + apart.y * apart.y;
    float stretched_size = stretched_across + 1.0e-5 * stretched_z2;
    float apart_size = apart_across + 4.0e-5;
    float cos_2_psi = (both.x * both.x * (stretch * stretch) - both.y * both.y / (stretch *
        stretch)) / stretched_size;
    float cos_2_p = (apart.x * apart.x - apart.y * apart.y) / apart_size;
    float psi_seen = stretched_across / stretched_size;
    float p_seen = apart_across / apart_size;
    float z2 = max(both.z * both.z, 1.0e-18);
    float squared = both.x * both.x + both.y * both.y + z2;
    float cos_d = min(0.5 * sqrt(squared), 1.0);
    float across = both.x * both.x + both.y * both.y;
    float factor2 = 2.0 * cos_2_psi * cos_2_psi - psi_seen * psi_seen;
    float factor3 = 2.0 * cos_2_p * cos_2_p - p_seen * p_seen;
    float factor4 = cos_2_psi * cos_2_p;
    float node0 = clamp((log(stretched_across / stretched_z2 + 1.0e-5) - (-11.512925)) * 0.05428681,
        0.0, 1.0) * 95.0;
    float node1 = clamp(sqrt(1.0 - cos_d), 0.0, 1.0) * 31.0;
    float node2 = clamp(1.0 - sqrt(1.0 - min(0.5 * abs(apart.z) / max(min(0.5 * both.z, sqrt(across
        / squared * ((1.0 - cos_d) * (1.0 + cos_d)))), 1.0e-9), 1.0)), 0.0, 1.0) * 7.0;
    float place0 = (node0 + 0.5) * 0.010416667;
    float place1 = (node1 + 0.5) * 0.03125;
    float first = node2 + 0.5;
    vec3 texel0_0_place = vec3(first * 0.020833334, place1, place0);
    vec4 texel0_0 = textureLod(table, texel0_0_place, 0.0);
    vec3 texel1_0_place = vec3((first + 8.0) * 0.020833334, place1, place0);
    vec4 texel1_0 = textureLod(table, texel1_0_place, 0.0);
    vec3 texel2_0_place = vec3((first + 16.0) * 0.020833334, place1, place0);
    vec4 texel2_0 = textureLod(table, texel2_0_place, 0.0);
    vec3 texel3_0_place = vec3((first + 24.0) * 0.020833334, place1, place0);
    vec4 texel3_0 = textureLod(table, texel3_0_place, 0.0);
    vec3 texel4_0_place = vec3((first + 32.0) * 0.020833334, place1, place0);
    vec4 texel4_0 = textureLod(table, texel4_0_place, 0.0);
    vec3 texel5_0_place = vec3((first + 40.0) * 0.020833334, place1, place0);
    vec4 texel5_0 = textureLod(table, texel5_0_place, 0.0);
    vec3 rest = exp(texel0_0.rgb + cos_2_psi * texel1_0.rgb + cos_2_p * texel2_0.rgb + factor2 *
        texel3_0.rgb + factor3 * texel4_0.rgb + factor4 * texel5_0.rgb);
    vec3 spread2_passed_i = max(numbers[0] * wi.x * (numbers[0] * wi.x) + numbers[6] * wi.y *
        (numbers[6] * wi.y), vec3(1.0e-9, 1.0e-9, 1.0e-9));
    vec3 passed_i = vec3(material_transmittance(spread2_passed_i.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wi.z), material_transmittance(spread2_passed_i.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wi.z), material_transmittance(spread2_passed_i.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wi.z));
    vec3 spread2_passed_o = max(numbers[0] * wo.x * (numbers[0] * wo.x) + numbers[6] * wo.y *
        (numbers[6] * wo.y), vec3(1.0e-9, 1.0e-9, 1.0e-9));
    vec3 passed_o = vec3(material_transmittance(spread2_passed_o.x, numbers[3].x, numbers[4].x,
        numbers[5].x, wo.z), material_transmittance(spread2_passed_o.y, numbers[3].y, numbers[4].y,
        numbers[5].y, wo.z), material_transmittance(spread2_passed_o.z, numbers[3].z, numbers[4].z,
        numbers[5].z, wo.z));
    return lobe + passed_i * passed_o * rest;
}
`,Ls=.8,Rs=18;function zs(e,t,n,r=[0,0]){let i=e.radius/(Ls*Math.tan(t.fov*Math.PI/360)),a=Math.max(t.elevation,Rs)*Math.PI/180,o=e.halfHeight*Math.cos(a)+e.width*Math.sin(a),s=Math.max(o,e.width/n)/Ls,c=s/(i*t.zoom),l=c*n,u=t.azimuth*Math.PI/180,d=t.elevation*Math.PI/180,f=[Math.cos(d)*Math.sin(u),-Math.cos(d)*Math.cos(u),Math.sin(d)],p=[Math.cos(u),Math.sin(u),0],m=[-Math.sin(d)*Math.sin(u),Math.sin(d)*Math.cos(u),Math.cos(d)],[h,g]=t.pan,_=e.centre.map((e,t)=>e+i*f[t]-s*(h*p[t]+g*m[t])),v=i-1.5*e.radius,y=i+1.5*e.radius,b=(e,t)=>[...e.map(e=>e*t),-t*aa(e,_)],x=[-f[0],-f[1],-f[2]],S=b(x,1),C=b(p,1/l).map((e,t)=>e+r[0]*S[t]),w=b(m,1/c).map((e,t)=>e+r[1]*S[t]),T=b(x,(y+v)/(y-v));T[3]-=2*y*v/(y-v);let E=[C,w,T,S];return{eye:_,right:[p[0]*l,p[1]*l,p[2]*l],up:[m[0]*c,m[1]*c,m[2]*c],forward:x,projection:[0,1,2,3].flatMap(e=>E.map(t=>t[e]))}}function Bs({eye:e,projection:t,...n}){let r=t.map((e,t)=>Math.floor(t/4)===2?-e:e);return{...n,eye:[e[0],e[1],-e[2]],projection:r}}function Vs(e){return e.length/128**2}function Hs(e){let t=t=>{let n=new Float32Array(12);return n.set(e.flatMap(e=>e[t])),n};return{lights:e.length,lightDirections:t(`direction`),lightPowers:t(`power`)}}var Us=`#version 300 es
// The share of its light that each place of the ground has beside the object: without the directions in
// which the object hides it.
precision highp float;
precision highp sampler2DArray;

uniform sampler2D lit; // light of the directions, see hemisphere.frag
uniform sampler2DArray shadows; // of a direction each, see core/occlusion.ts
uniform int axes;

out vec4 colour;

void main() {
    vec3 open = vec3(0.0), all = vec3(0.0);
    for (int axis = 0; axis < axes; axis++) {
        vec3 light = texelFetch(lit, ivec2(axis, 0), 0).rgb;
        all += light;
        open += light * (1.0 - texelFetch(shadows, ivec3(gl_FragCoord.xy, axis), 0).r);
    }
    colour = vec4(axes == 0 ? vec3(1.0) : open / max(all, 1e-6), 1.0);
}
`,Ws=`#version 300 es
// Radiance from each of many directions of the upper hemisphere, by their cosines: the environment's, and
// the bright lights', which lobes of the integral 1 spread over the directions beside them.
precision highp float;
precision highp samplerCube;

const int MOST_LIGHTS = 4;
const float PI = 3.14159265;

uniform samplerCube environment;
uniform int axes;
uniform vec2 turn;
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS];
uniform int lights;

out vec4 colour;

void main() {
    float count = max(float(axes), 1.0), axis = floor(gl_FragCoord.x);
    float level = 8.0 - 0.5 * log2(count); // its texels are as large as the share of one direction
    float z = min((axis + 0.5) / count, 1.0); // see core/occlusion.ts
    float phi = axis * PI * (3.0 - sqrt(5.0));
    vec2 xy = sqrt(1.0 - z * z) * vec2(cos(phi), sin(phi));
    vec3 direction = vec3(turn.x * xy.x + turn.y * xy.y, turn.x * xy.y - turn.y * xy.x, z);
    vec3 light = z * textureLod(environment, direction, level).rgb;
    for (int i = 0; i < lights; i++) {
        float narrow = 0.4 * count;
        float near = exp((dot(direction, lightDirections[i]) - 1.0) * narrow);
        light += lightPowers[i] * lightDirections[i].z * near * narrow / (2.0 * PI);
    }
    colour = vec4(light, 1.0);
}
`,Gs=`#version 300 es
// The ground's light with the steps between directions smoothed, the more the farther from the object.
precision highp float;

uniform sampler2D sharp;
uniform float contact; // radius of the object relative to half the square

in vec2 place;
out vec4 colour;

void main() {
    float radius = 0.12 * max(length(place) - 0.5 * contact, 0.01);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 24; k++) {
        float angle = 2.39996323 * float(k);
        vec2 shift = radius * sqrt((float(k) + 0.5) / 24.0) * vec2(cos(angle), sin(angle));
        sum += textureLod(sharp, 0.5 * (place + shift) + 0.5, 0.0);
    }
    colour = sum / 24.0;
}
`,Ks=class{gl;program;hemisphere;soften;lit;sharp;smooth;shadows;axes=0;key=``;constructor(e){this.gl=e,this.program=new Z(e,Us),this.hemisphere=new Z(e,Ws),this.soften=new Z(e,Gs),this.shadows=e.createTexture(),this.lit=new Qo(e,256,1,[e.RGBA16F]),this.sharp=new Qo(e,128,128,[e.RGBA16F]),this.smooth=new Qo(e,128,128,[e.RGBA16F]),this.setShadows(new Uint8Array)}get texture(){return this.smooth.textures[0]}setShadows(e){let{gl:t}=this;this.axes=Vs(e),this.key=``;let n=t.TEXTURE_2D_ARRAY,[r,i]=this.axes>0?[128,this.axes]:[1,1],a=this.axes>0?e:new Uint8Array(1);t.activeTexture(t.TEXTURE0),t.bindTexture(n,this.shadows),t.pixelStorei(t.UNPACK_ALIGNMENT,1),t.texImage3D(n,0,t.R8,r,r,i,0,t.RED,t.UNSIGNED_BYTE,a),Zo(t,n,t.NEAREST,t.NEAREST,t.CLAMP_TO_EDGE)}changed(){this.key=``}light(e,t,n,r){let i=String(n);if(i===this.key)return;this.key=i;let{axes:a,shadows:o}=this,s=(e,t,n)=>(e.bind(),t.cover(n),e.textures[0]),c={environment:e.texture,axes:a,turn:n,...Hs(t)},l=s(this.lit,this.hemisphere,c),u=s(this.sharp,this.program,{lit:l,shadows:o,axes:a});s(this.smooth,this.soften,{sharp:u,contact:r})}},qs=`// The parts of object.frag for anisotropic materials: tables by the cosine and the azimuth of the view,
// in the frame of the material's tangent.
uniform int azimuths; // the table's columns are the cosines of one azimuth after the other
uniform vec3 lobe[7]; // numbers of the material's lobe
uniform vec3 stretches; // of the channels
uniform float rotation; // of the material's tangent [radians]

#include basis.glsl

// The frame along the tangent, mirrored so that the view is in the first quadrant.
Frame tangentFrame(Frame frame, ivec2 pixel) {
    vec4 stored = texelFetch(normals, pixel, 0);
    mat3 axes = basis(stored.xyz);
    float angle = stored.w + rotation;
    vec3 tangent = turned(cos(angle) * axes[0] + sin(angle) * axes[1]);
    tangent = normalize(tangent - dot(tangent, frame.z) * frame.z);
    vec3 bitangent = cross(frame.z, tangent);
    vec3 view = frame.view.x * frame.x + frame.view.z * frame.z;
    vec2 flat_ = vec2(dot(view, tangent), dot(view, bitangent));
    vec2 side = vec2(flat_.x < 0.0 ? -1.0 : 1.0, flat_.y < 0.0 ? -1.0 : 1.0);
    return Frame(side.x * tangent, side.y * bitangent, frame.z, vec3(abs(flat_), frame.view.z));
}

vec3 reflected(Frame frame) {
    int columns = textureSize(table, 0).x / azimuths;
    float column = clamp(frame.view.z * float(columns) - 0.5, 0.0, float(columns) - 1.0);
    float row = atan(frame.view.y, frame.view.x + 1e-9) / 1.5707963 * float(azimuths - 1);
    int left = int(column), below = min(int(row), azimuths - 2);
    int right = min(left + 1, columns - 1);
    float across = column - float(left), up = clamp(row - float(below), 0.0, 1.0);
    ivec4 places = ivec4(left, right, left, right) + ivec2(below, below + 1).xxyy * columns;
    vec4 shares = vec4((1.0 - across) * (1.0 - up), across * (1.0 - up), (1.0 - across) * up, across * up);
    int last = textureSize(table, 0).y - 2;
    vec3 total = vec3(0.0), albedo = vec3(0.0);
    for (int k = 0; k < 4; k++) {
        total += float(samples) * shares[k] * texelFetch(table, ivec2(places[k], last), 0).rgb;
        albedo += shares[k] * texelFetch(table, ivec2(places[k], last + 1), 0).rgb;
    }
    vec3 even = textureLod(irradiance, bent, 0.0).rgb;
    own = albedo * meanLight(frame.z);
    vec3 sum = total * mix(own, even, openness);
    for (int i = 0; i < samples; i++) {
        vec4 facets[4], between = vec4(0.0);
        vec3 weights[4], weight = vec3(0.0);
        bool isOne = true;
        for (int k = 0; k < 4; k++) {
            facets[k] = texelFetch(table, ivec2(places[k], 2 * i), 0);
            weights[k] = texelFetch(table, ivec2(places[k], 2 * i + 1), 0).rgb;
            isOne = isOne && dot(facets[0].xyz, facets[k].xyz) > 0.97
                && abs(facets[0].w - facets[k].w) < 2.0;
            between += shares[k] * facets[k];
            weight += shares[k] * weights[k];
        }
        total += weight;
        if (isOne) {
            sum += weight * mirrored(frame, between);
        } else { // of different lobes of the proposal
            for (int k = 0; k < 4; k++) {
                sum += shares[k] * weights[k] * mirrored(frame, facets[k]);
            }
        }
    }
    return max(sum, 0.0) * albedo / max(total, 1e-6);
}

vec3 f(Frame frame, vec3 light) {
    vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
    vec3 wide[7] = lobe; // over the normals of the pixel
    for (int k = 0; k < 7; k += 6) wide[k] = sqrt(lobe[k] * lobe[k] + 0.25 * spread * spread);
    vec3 one = material_f2(wide, stretches.r, rest, frame.view, local);
    if (stretches.r == stretches.g && stretches.r == stretches.b) return one;
    return vec3(one.r, material_f2(wide, stretches.g, rest, frame.view, local).g,
                material_f2(wide, stretches.b, rest, frame.view, local).b);
}
`,Js=`#version 300 es
// What lies behind the object: a ground and a wall in the environment's light, or a panorama out of focus;
// with the object's shadow, and its reflection in the ground.
precision highp float;
precision highp samplerCube;

uniform vec3 eye;
uniform vec3 right; // to the picture's right edge, at the distance of 1
uniform vec3 up;
uniform vec3 forward;
uniform vec2 turn;
uniform samplerCube environment;
uniform samplerCube irradiance; // over pi, by the normal
uniform sampler2D ground; // share of the light that it has
uniform sampler2D mirror; // the object as the ground reflects it, times opacity
uniform vec4 toMirror; // from pixels to its texels: shift and factors; 0: there is none
uniform vec2 size; // radius of the object, and half the side of the square in \`ground\`
uniform bool isPanorama;
uniform bool isPlain; // whether there are shadow and reflection alone

in vec2 place;
out vec4 colour;

const float BLUR = 4.0; // level of a panorama
const float WIDER = 3.0; // its width relative to the picture's, to show the horizon from above
const vec2 GREY = vec2(0.24, 0.08); // ground and wall, a little in the light's colour

vec3 inEnvironment(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

// What the ground reflects, times opacity.
vec4 reflection(vec3 direction) {
    vec2 texel = 1.0 / vec2(textureSize(mirror, 0));
    vec2 at = (gl_FragCoord.xy * toMirror.zw + toMirror.xy) * texel;
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; k++) {
        sum += textureLod(mirror, at + texel * (vec2(float(k % 2), float(k / 2)) - 0.5), 0.0);
    }
    float share = 0.1 + 0.9 * pow(1.0 - abs(direction.z), 5.0); // of a polished floor, as of Schlick (1994)
    return share * sum / 4.0;
}

void main() {
    vec3 direction = normalize(forward + place.x * right + place.y * up);
    vec3 above = textureLod(irradiance, vec3(0.0, 0.0, 1.0), 0.0).rgb;
    vec3 tint = mix(vec3(1.0), above / max(dot(above, vec3(0.2126, 0.7152, 0.0722)), 1e-4), 0.15);
    vec3 light = GREY.y * tint;
    vec3 shade = vec3(1.0);
    vec4 seen = vec4(0.0);
    if (direction.z < -1e-3 && eye.z > 0.0) {
        vec2 at = (eye - direction * (eye.z / direction.z)).xy;
        float away = length(at) / size.x;
        light = mix(light, GREY.x * tint, 1.0 / (1.0 + 0.05 * away * away)); // a pool of light
        vec2 inside = abs(at) / size.y;
        float border = smoothstep(1.0, 0.8, max(inside.x, inside.y));
        shade = mix(vec3(1.0), textureLod(ground, 0.5 * at / size.y + 0.5, 0.0).rgb, border);
        if (toMirror.z > 0.0 && away < 4.0) {
            seen = reflection(direction);
        }
    }
    if (isPanorama) {
        vec3 wide = normalize(forward + WIDER * (place.x * right + place.y * up));
        light = textureLod(environment, inEnvironment(wide), BLUR).rgb;
    }
    float dark = dot(shade, vec3(0.2126, 0.7152, 0.0722));
    // What is laid over an encoded colour darkens it by the curve of the screen.
    vec4 behind = isPlain ? vec4(vec3(0.0), 1.0 - pow(dark, 1.0 / 2.2)) : vec4(shade * light, 1.0);
    colour = vec4(seen.rgb, seen.a) + (1.0 - seen.a) * behind;
}
`,Ys=`// A frame of which z is a normal (Duff et al. 2017).
mat3 basis(vec3 z) {
    float side = z.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (side + z.z), b = z.x * z.y * a;
    vec3 x = vec3(1.0 + side * z.x * z.x * a, side * b, -side * z.x);
    return mat3(x, vec3(b, side + z.y * z.y * a, -z.y), z);
}
`,Xs=`#version 300 es
// A frame, to be blended with what has been gathered.
precision highp float;

uniform sampler2D frame;

in vec2 place;
out vec4 colour;

void main() {
    colour = texelFetch(frame, ivec2(gl_FragCoord.xy), 0);
}
`,Zs=`#version 300 es
// Exposure, a tone curve, sRGB, and what lies behind the picture; or the colour difference of two
// pictures that lie beside each other.
precision highp float;

uniform sampler2D picture;
uniform float exposure;
uniform int tone; // 0: neutral, 1: filmic, 2: none
uniform vec4 behind; // colour (sRGB) and opacity where the picture is transparent
uniform float scale; // colour difference that is shown by the last colour; 0: one picture, -1: numbers

in vec2 place;
out vec4 colour;

const float START = 0.8 - 0.04;
const float DESATURATION = 0.15;

// "PBR Neutral" of the Khronos Group (2024).
vec3 neutral(vec3 light) {
    float least = min(light.r, min(light.g, light.b));
    float offset = least < 0.08 ? least - 6.25 * least * least : 0.04;
    light -= offset;
    float peak = max(light.r, max(light.g, light.b));
    if (peak < START) {
        return light;
    }
    float rest = 1.0 - START;
    float lowered = 1.0 - rest * rest / (peak + rest - START);
    light *= lowered / peak;
    float grey = 1.0 - 1.0 / (DESATURATION * (peak - lowered) + 1.0);
    return mix(light, vec3(lowered), grey);
}

// The Academy's ACES, as fitted by Hill (2017, BakingLab), with the exposure of three.js.
vec3 filmic(vec3 light) {
    mat3 toAces = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    mat3 toRgb = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605,
                      1.07602);
    vec3 x = toAces * light / 0.6;
    return toRgb * ((x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081));
}

// Noise of half a step, against bands in smooth gradients.
float dither(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
}

// Linear sRGB as it is shown, and opacity, at a place in [0, 1]^2 of the texture.
vec4 shownAt(vec2 at) {
    vec4 texel = max(textureLod(picture, at, 0.0), 0.0);
    float opacity = min(texel.a, 1.0);
    vec3 light = texel.rgb / max(opacity, 1e-4) * exposure;
    if (tone < 2) {
        light = tone == 0 ? neutral(light) : filmic(light);
    }
    return vec4(clamp(light, 0.0, 1.0), opacity);
}

// CIELAB of linear sRGB, with the white of D65 (CIE 15).
vec3 lab(vec3 rgb) {
    mat3 toXyz = mat3(0.4339, 0.2126, 0.0178, 0.3762, 0.7152, 0.1095, 0.1899, 0.0722, 0.8727);
    vec3 xyz = toXyz * rgb; // relative to white
    vec3 t = mix(7.787 * xyz + 16.0 / 116.0, pow(xyz, vec3(1.0 / 3.0)), step(0.008856, xyz));
    return vec3(116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z));
}

// Colours of a difference from 0 to 1; the legend on the page has the same.
vec3 difference(float x) {
    vec3 colours[5] = vec3[5](vec3(0.0, 0.0, 4.0), vec3(81.0, 18.0, 124.0), vec3(183.0, 55.0, 121.0),
                              vec3(252.0, 137.0, 97.0), vec3(252.0, 253.0, 191.0));
    float at = 4.0 * clamp(x, 0.0, 1.0);
    int low = min(int(at), 3);
    return mix(colours[low], colours[low + 1], at - float(low)) / 255.0;
}

void main() {
    if (scale != 0.0) {
        float border = 0.5 / float(textureSize(picture, 0).x);
        vec2 left = vec2(clamp(0.25 * place.x + 0.25, border, 0.5 - border), 0.5 * place.y + 0.5);
        vec3 between = lab(shownAt(left).rgb) - lab(shownAt(left + vec2(0.5, 0.0)).rgb);
        float size = length(between);
        colour = vec4(scale > 0.0 ? difference(size / scale) : vec3(size), 1.0);
        return;
    }
    vec4 shown = shownAt(0.5 * place + 0.5);
    vec3 encoded = mix(12.92 * shown.rgb, 1.055 * pow(shown.rgb, vec3(1.0 / 2.4)) - 0.055,
                       step(0.0031308, shown.rgb));
    encoded += dither(gl_FragCoord.xy) / 255.0;
    float rest = (1.0 - shown.a) * behind.a;
    colour = vec4(shown.a * encoded + rest * behind.rgb, shown.a + rest); // premultiplied
}
`,Qs=`// What a pixel shows of the object, and the light there.
const int MOST_LIGHTS = 4;

uniform vec3 eye;
uniform vec2 turn; // cosine and sine of the environment's rotation about z
uniform int samples;
uniform float density; // directions taken so far, for the level of detail
uniform float footprint; // share of a pixel that a frame shows: the mean of more frames needs less
uniform samplerCube environment;
uniform float side; // texels along a side of the environment
uniform vec3 lightDirections[MOST_LIGHTS];
uniform vec3 lightPowers[MOST_LIGHTS]; // irradiance at normal incidence
uniform int lights;

uniform float fade; // height at which the image in the ground fades; 0: it is none
uniform samplerCube irradiance; // over pi, by the normal
uniform sampler2D positions; // of the surface that each pixel shows, see surface.frag
uniform sampler2D normals;
uniform sampler2D openings;

// A pixel's frame, in which z is the normal, and its direction to the eye.
struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
    vec3 view;
};

vec3 turned(vec3 v) {
    return vec3(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x, v.z);
}

vec3 bent; // the mean direction of the light that the object does not hide
float edge; // cosine of the angle about it beyond which light is hidden
float spread; // how far the normal turns across what is shown
float openness; // share of the light that the object does not hide, by the cosine
vec3 own; // light of the object itself where it hides the environment

// The frame where a pixel shows a position; position: as of surface.frag.
Frame frameAt(ivec2 pixel, vec4 position) {
    float bend = footprint * (position.w - 1.0);
    spread = bend * bend / (bend + 0.15); // next to nothing where the surface hardly bends
    vec3 normal = turned(texelFetch(normals, pixel, 0).xyz);
    vec3 view = turned(normalize(eye - position.xyz));
    float cosine = dot(normal, view);
    // Smooth normals may turn away at the silhouette, where a coarse pixel shows the mean of many.
    float least = max(0.5 * cosine + 0.25 * spread, 0.004);
    if (cosine < least) {
        normal = normalize(normal + (least - cosine) * view);
        cosine = max(dot(normal, view), 0.004);
    }
    vec3 across = view - cosine * normal;
    float size = length(across);
    vec3 tangent = size > 1e-4
        ? across / size
        : normalize(cross(normal, abs(normal.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    vec4 opening = texelFetch(openings, pixel, 0);
    bent = turned(opening.xyz);
    openness = opening.w;
    // The cosine at the edge of a cone of the openness (Oat and Sander 2007)
    edge = sqrt(max(1.0 - openness / clamp(dot(normal, bent), 0.02, 1.0), 0.0));
    return Frame(tangent, cross(normal, tangent), normal, vec3(size, 0.0, cosine));
}

// The level whose texels are as large as the share of one direction, or as what the pixel reflects:
// thin rims would else be dashed in coarse frames.
float level(vec3 direction, float logPdf) {
    vec3 size = abs(direction);
    float major = max(size.x, max(size.y, size.z));
    float solidAngle = 4.0 * major * major * major / (side * side); // of a texel
    float share = max(exp2(-logPdf) / density, 2.0 * spread * spread);
    return 0.5 * log2(share / solidAngle) + 0.5;
}

// Light on the parts that hide the environment: of all directions, as far as it gets there.
vec3 meanLight(vec3 normal) {
    vec3 both = textureLod(irradiance, normal, 0.0).rgb + textureLod(irradiance, -normal, 0.0).rgb;
    return 0.5 * openness * both;
}

// The share of a direction that is open: of a cone about the bent normal.
float open(vec3 light) {
    float soft = min(edge, 0.25) + 1e-4;
    return openness == 1.0 ? 1.0 : smoothstep(edge - soft, edge + soft, dot(light, bent));
}

// Light from a direction in a frame, drawn by a density.
vec3 incoming(Frame frame, vec3 local, float logPdf) {
    vec3 light = local.x * frame.x + local.y * frame.y + local.z * frame.z;
    return mix(own, textureLod(environment, light, level(light, logPdf)).rgb, open(light));
}

// Light of a surface at a height, times its opacity. Coarse images have no highlights.
vec4 faded(vec3 light, float height) {
    return fade > 0.0 ? vec4(min(light, 2.0), 1.0) * exp(-height / fade) : vec4(light, 1.0);
}
`,$s=`#version 300 es
// Reflected light: a sum over the table's directions, which looks up the prefiltered environment,
// and the bright lights, which are evaluated directly.
precision highp float;
precision highp samplerCube;
precision highp sampler3D;

#include frame.glsl

uniform sampler2D table; // columns: cosines; rows as in direction_table.ts

out vec4 colour;

// Light from the direction that is the mirror image of the view in a facet of the table.
vec3 mirrored(Frame frame, vec4 facet) {
    vec3 half_ = normalize(facet.xyz);
    return incoming(frame, 2.0 * dot(frame.view, half_) * half_ - frame.view, facet.w);
}

#include material.glsl

uniform sampler3D rest; // the material's table

#ifdef ANISOTROPIC
#include anisotropic.glsl
#else
uniform vec3 lobe[6]; // numbers of the material's lobe

// The mean light of the diffuse part and of the table's directions by their weights, times the albedo:
// a few directions thus reflect as much as all.
vec3 reflected(Frame frame) {
    int columns = textureSize(table, 0).x;
    float column = clamp(frame.view.z * float(columns) - 0.5, 0.0, float(columns) - 1.0);
    int left = int(column);
    int right = min(left + 1, columns - 1);
    float share = column - float(left);
    int last = textureSize(table, 0).y - 2;
    vec3 total = float(samples) * mix(texelFetch(table, ivec2(left, last), 0).rgb,
                                      texelFetch(table, ivec2(right, last), 0).rgb, share);
    vec3 albedo = mix(texelFetch(table, ivec2(left, last + 1), 0).rgb,
                      texelFetch(table, ivec2(right, last + 1), 0).rgb, share);
    vec3 even = textureLod(irradiance, bent, 0.0).rgb;
    own = albedo * meanLight(frame.z);
    vec3 sum = total * mix(own, even, openness);
    for (int i = 0; i < samples; i++) {
        vec4 first = texelFetch(table, ivec2(left, 2 * i), 0);
        vec4 second = texelFetch(table, ivec2(right, 2 * i), 0);
        vec3 firstWeight = texelFetch(table, ivec2(left, 2 * i + 1), 0).rgb;
        vec3 secondWeight = texelFetch(table, ivec2(right, 2 * i + 1), 0).rgb;
        total += mix(firstWeight, secondWeight, share);
        if (dot(first.xyz, second.xyz) > 0.97 && abs(first.w - second.w) < 2.0) {
            vec4 between = mix(first, second, share);
            sum += mix(firstWeight, secondWeight, share) * mirrored(frame, between);
        } else { // of different lobes of the proposal
            sum += (1.0 - share) * firstWeight * mirrored(frame, first);
            sum += share * secondWeight * mirrored(frame, second);
        }
    }
    return max(sum, 0.0) * albedo / max(total, 1e-6);
}

vec3 f(Frame frame, vec3 light) {
    vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
    vec3 wide[6] = lobe; // over the normals of the pixel (Kaplanyan et al. 2016)
    wide[0] = sqrt(lobe[0] * lobe[0] + 0.25 * spread * spread);
    return material_f(wide, rest, frame.view, local);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(positions, pixel, 0);
    if (position.w <= 0.0) {
        colour = vec4(0.0);
        return;
    }
    Frame frame = frameAt(pixel, position);
#ifdef ANISOTROPIC
    frame = tangentFrame(frame, pixel);
#endif
    vec3 sum = reflected(frame);

    for (int i = 0; i < lights; i++) {
        float cosLight = dot(frame.z, lightDirections[i]);
        if (cosLight > 0.0) {
            sum += f(frame, lightDirections[i]) * cosLight * open(lightDirections[i]) * lightPowers[i];
        }
    }
    colour = faded(sum, position.z);
}
`,ec=`#version 300 es
// The object as the camera sees it.
uniform mat4 projection; // world to clip space
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 coordinates;
layout(location = 3) in vec3 tangent;
layout(location = 4) in vec4 bent; // bent normal, 0 before it is known, and openness
out vec3 worldPosition;
out vec3 worldNormal;
out vec3 worldTangent;
out vec2 uv;
out vec4 opening;

void main() {
    worldPosition = position;
    worldNormal = normal;
    worldTangent = tangent;
    uv = coordinates;
    opening = vec4(bent.xyz == vec3(0.0) ? normal : bent.xyz, max(bent.w, 0.02));
    gl_Position = projection * vec4(position, 1.0);
}
`,tc=`#version 300 es
// The object's triangles in the colours that were computed for coarse pixels: the mean of the nearest
// ones that show the same part of the surface (Kopf et al. 2007).
precision highp float;

uniform sampler2D shaded;
uniform sampler2D positions; // and what is above 0; -1 for a back, 0 where there is no surface
uniform sampler2D normals;
uniform vec4 toShaded; // from pixels to coarse ones: shift and factors
uniform float near; // distance from the tangent plane at which a surface is another

in vec3 worldPosition;
in vec3 worldNormal;
out vec4 colour;

vec4 same = vec4(0.0); // sum of colours and of weights, by the part of the surface
vec4 any = vec4(0.0); // whatever they show

// Add a coarse pixel; place: relative to the place of this pixel.
void add(ivec2 texel, vec2 place, vec3 normal) {
    texel = clamp(texel, ivec2(0), textureSize(shaded, 0) - 1);
    vec4 other = texelFetch(positions, texel, 0);
    if (other.w <= 0.0) {
        return;
    }
    vec2 close = max(1.0 - abs(place), 2e-3);
    vec4 light = vec4(texelFetch(shaded, texel, 0).rgb, 1.0) * close.x * close.y;
    float aside = dot(other.xyz - worldPosition, normal) / near;
    float facing = max(dot(normal, texelFetch(normals, texel, 0).xyz), 0.0);
    // By products, since each of the picture's pixels is here
    float facing2 = facing * facing, facing4 = facing2 * facing2;
    float facing8 = facing4 * facing4, facing24 = facing8 * facing8 * facing8;
    any += light * (facing4 + 1e-4);
    same += light * facing24 * exp(-aside * aside);
}

void main() {
    colour = vec4(0.0, 0.0, 0.0, 1.0);
    if (!gl_FrontFacing) {
        return; // materials do not reflect on their backs
    }
    vec3 normal = normalize(worldNormal);
    vec2 at = gl_FragCoord.xy * toShaded.zw + toShaded.xy - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 share = at - vec2(first);
    for (int k = 0; k < 4; k++) {
        ivec2 step_ = ivec2(k & 1, k >> 1);
        add(first + step_, vec2(step_) - share, normal);
    }
    if (same.a < 1e-3) {
        for (int k = 0; k < 16; k++) {
            ivec2 step_ = ivec2(k & 3, k >> 2) - 1;
            add(first + step_, vec2(step_) - share, normal);
        }
    }
    if (same.a >= 1e-3) {
        colour.rgb = same.rgb / same.a;
    } else if (any.a > 0.0) {
        colour.rgb = any.rgb / any.a;
    }
}
`,nc=`#version 300 es
// The surface that a pixel shows, to be shaded once: triangles smaller than pixels would be shaded
// several times each.
precision highp float;

uniform mat3x2 toTexture; // from uv, where a texture of codes is shown

in vec3 worldPosition;
in vec3 worldNormal;
in vec3 worldTangent;
in vec2 uv;
in vec4 opening;
layout(location = 0) out vec4 position; // and 1 + the normal's turn across a pixel; -1 for a back, 0: none
layout(location = 1) out vec4 normal; // and the tangent's angle in its \`basis\`
layout(location = 2) out vec4 at; // in the texture
layout(location = 3) out vec4 open; // bent normal and openness

#include basis.glsl

void main() {
    vec3 unit = normalize(worldNormal);
    float across = max(length(dFdx(unit)), length(dFdy(unit)));
    position = vec4(worldPosition, gl_FrontFacing ? 1.0 + min(across, 1.5) : -1.0);
    open = vec4(normalize(opening.xyz), opening.w);
    mat3 frame = basis(unit);
    normal = vec4(unit, atan(dot(worldTangent, frame[1]), dot(worldTangent, frame[0])));
    at = vec4(toTexture * vec3(uv, 1.0), 0.0, 0.0);
}
`,rc={count:1,column:0,row:0};function ic([e,t,n,r],i,a){let[o,s]=[Math.floor(e*i)-a,Math.floor(t*i)-a];return[o,s,Math.ceil((e+n)*i)+a-o,Math.ceil((t+r)*i)+a-s]}function ac(e,t,n){let r=Math.floor(t/2),i=Math.round(t*e.edge),[a,o]=[0,1].map(e=>({slot:e,x:0,width:t,from:0,to:t,offset:0}));switch(e.comparison){case`off`:return[{...a,slot:e.slot}];case`side`:return[{...a,width:r,to:r},{...o,x:r,width:t-r,from:r}];case`difference`:return[a,{...o,offset:n}];case`swipe`:return[{...a,to:i},{...o,from:i}]}}function oc(e){return e===0?[0,0]:[sc(e,2)-.5,sc(e,3)-.5]}function sc(e,t){let n=0,r=1;for(let i=e;i>0;i=Math.floor(i/t))r/=t,n+=i%t*r;return n}var[cc,lc]=[3,1.001];function uc(e,t,n){let{azimuths:r,cosines:i,samples:a}=t,o=r*i,s=new Float32Array(4*o*(2*a+2)),c=s.subarray(8*o*a),l=fc(e,t);for(let n=0;n<o;n++){let r=ro(n,t),u=e.subarray(8*n*a,8*(n+1)*a),d=l.subarray(n%i*4,n%i*4+3);for(let e=0;e<u.length;e+=8){let[t,i,l]=[u[e]+r.x,u[e+1]+r.y,u[e+2]+r.z],f=Math.hypot(t,i,l)||1,p=Math.log2(Math.max(u[e+6],1e-6)),m=d.map((t,n)=>u[e+3+n]-t*dc(u,e));for(let t=0;t<3;t++)c[4*(o+n)+t]+=u[e+3+t]/a;let h=o*e+4*n;s.set([t/f,i/f,l/f,p],h),s.set(m,h+4*o)}c.set(d,4*n)}return n&&c.set(pc(c.subarray(4*o),i),4*o),s}function dc(e,t){return e[t+6]>0?e[t+2]/(Math.PI*e[t+6]):0}function fc(e,{cosines:t,samples:n}){let r=new Float32Array(4*t).fill(1/0);for(let i=0;i<cc;i++){let[i,a]=[new Float32Array(4*t),new Float32Array(4*t)];for(let o=0;o<e.length;o+=8){let s=4*(Math.floor(o/(8*n))%t),c=dc(e,o);for(let t=0;t<3;t++)e[o+3+t]>lc*c*r[s+t]||(i[s+t]+=c*e[o+3+t],a[s+t]+=c*c)}let o=pc(a,t);r=pc(i,t).map((e,t)=>e/Math.max(o[t],1e-9))}return r}function pc(e,t){return e.map((n,r)=>{let i=Math.floor(r/4)%t,a=Math.min(4,i>>1,t-1-i),o=0;for(let t=-a;t<=a;t++)o+=e[r+4*t];return o/(2*a+1)})}var mc=`#version 300 es
// Reflected light of a texture of codes: a texel's material by the exported shader code, directions
// by its proposal with the prefiltered environment, and the bright lights directly.
precision highp float;
precision highp samplerCube;
precision highp sampler2DArray;

#include frame.glsl

float stored[4 * LAYERS]; // bytes of the texel, in [0, 1]

#include material.glsl

uniform sampler2DArray codes; // of the texture
uniform highp sampler3D functions; // of the basis
uniform sampler2D places; // in the texture, see surface.frag
uniform vec3 start; // of the sequence of directions

// Steps of the sequence (Roberts 2018).
const vec3 STEPS = vec3(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);

out vec4 colour;

uvec3 mixed(uvec3 v) {
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Three numbers in [0, 1) for each pixel: pcg3d of Jarzynski and Olano 2020.
vec3 hash(uvec3 v) {
    v = mixed(v * 1664525u + 1013904223u);
    v = mixed(v ^ (v >> 16u));
    return vec3(v >> 8u) / 16777216.0;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(positions, pixel, 0);
    if (position.w <= 0.0) {
        colour = vec4(0.0);
        return;
    }
    // One texel is drawn in proportion to its weight, so that the mean of the frames filters f and
    // not the code.
    vec2 at = texelFetch(places, pixel, 0).xy;
    vec2 random = fract(hash(uvec3(pixel, 0)).xy + start.zx);
    at += SPREAD * (random - 0.5) / vec2(textureSize(codes, 0).xy);
    for (int layer = 0; layer < LAYERS; layer++) {
        vec4 four = textureLod(codes, vec3(at, float(layer)), 0.0);
        stored[4 * layer] = four.r;
        stored[4 * layer + 1] = four.g;
        stored[4 * layer + 2] = four.b;
        stored[4 * layer + 3] = four.a;
    }
    UrushiMaterial material = urushi_material();
    Frame frame = frameAt(pixel, position);
    UrushiProposal proposal = urushi_proposal(material, frame.view);

    own = 0.5 * meanLight(frame.z); // of an object of average albedo
    vec3 sum = vec3(0.0);
    for (int i = 0; i < samples; i++) {
        vec3 direction = urushi_draw(proposal, frame.view, fract(start + float(i) * STEPS));
        float pdf = urushi_density(proposal, frame.view, direction);
        if (pdf > 0.0) {
            vec3 weight = urushi_f(material, frame.view, direction, functions) * (direction.z / pdf);
            sum += weight * incoming(frame, direction, log2(pdf));
        }
    }
    sum /= float(samples);

    for (int i = 0; i < lights; i++) {
        vec3 light = lightDirections[i];
        vec3 local = vec3(dot(light, frame.x), dot(light, frame.y), dot(light, frame.z));
        if (local.z > 0.0) {
            sum += urushi_f(material, frame.view, local, functions) * local.z * open(light) * lightPowers[i];
        }
    }
    colour = faded(sum, position.z);
}
`;function hc(e,t){let{texture:n,shader:r,basis:i}=t,a=e.getParameter(e.MAX_TEXTURE_SIZE),[o,s]=n.size;if(Math.max(o,s)>a)throw new B(`The texture has ${o} by ${s} texels; the graphics driver takes ${a} a side.`);let c=Math.max(Math.ceil(n.usedBytes/4),1);return{program:new Z(e,Xo(mc,{"frame.glsl":Qs,"material.glsl":r}).replaceAll(`LAYERS`,String(c)),{SPREAD:+!n.nearest}),texture:vc(e,n,c),basis:gc(e,e.createTexture(),i)}}function gc(e,t,n){let[r,i]=er.SHAPE,a=n.length/(4*r*i);e.activeTexture(e.TEXTURE0);let o=e.TEXTURE_3D;e.bindTexture(o,t);let s=e.getExtension(`OES_texture_float_linear`)===null?e.RGBA16F:e.RGBA32F;return e.texImage3D(o,0,s,a,i,r,0,e.RGBA,e.FLOAT,n),Zo(e,o,e.LINEAR,e.LINEAR,e.CLAMP_TO_EDGE),t}function _c({logs:e}){let t=er.SHAPE[2],n=e.length/(3*Xi),r=new Float32Array(4*Xi*n);for(let i=0;i<e.length;i++){let[a,o]=[Math.floor(i/n),i%n],[s,c]=[Math.floor(a/3),a%3],l=(Math.floor(s/t)*n+o)*t+s%t;r[4*l+c]=e[i]}return r}function vc(e,t,n){let{size:r,texels:i,texelBytes:a}=t,[o,s]=r,c=e.TEXTURE_2D_ARRAY,l=e.createTexture();e.activeTexture(e.TEXTURE0),e.bindTexture(c,l),e.texStorage3D(c,1,e.RGBA8,o,s,n),e.pixelStorei(e.UNPACK_ALIGNMENT,4);let u=new Uint8Array(4*o*s);for(let t=0;t<n;t++){for(let e=0;e<o*s;e++){let n=e*a+4*t;for(let t=0;t<4;t++)u[4*e+t]=i[n+t]}e.texSubImage3D(c,0,0,0,t,o,s,1,e.RGBA,e.UNSIGNED_BYTE,u)}return Zo(e,c,e.NEAREST,e.NEAREST,yc(e,t.wrap)),l}function yc(e,t){return t===`clamp`?e.CLAMP_TO_EDGE:t===`mirror`?e.MIRRORED_REPEAT:e.REPEAT}var bc=32;function xc({latents:e,table:t}){let n=ir.NUMBERS[t.stretches?2:1].length,r=Nt(e,e.length/3);return Float32Array.from({length:n*3},(e,n)=>{let[i,a]=[Math.floor(n/3),n%3];return i>=1&&i<=3&&!t.besideLobe?0:r[a][i]})}var Sc=class{gl;texels=null;codes=null;table;sizes={azimuths:1,cosines:1,samples:0};rotation=0;material=null;lobe=new Float32Array(18).fill(1,0,3);rest;stretches=[1,1,1];constructor(e){this.gl=e,this.table=e.createTexture();let t=new Float32Array(4*Xi).fill(-18);this.rest=gc(e,e.createTexture(),t)}get isAnisotropic(){return this.sizes.azimuths>1}setTable(e,t,n,r){let{gl:i}=this;this.sizes=t,this.rotation=n*Math.PI/180,i.activeTexture(i.TEXTURE0),i.bindTexture(i.TEXTURE_2D,this.table);let[a,o]=[t.azimuths*t.cosines,2*t.samples+2],s=uc(e,t,r),c=i.TEXTURE_2D;i.texImage2D(c,0,i.RGBA32F,a,o,0,i.RGBA,i.FLOAT,s),Zo(i,c,i.NEAREST,i.NEAREST,i.CLAMP_TO_EDGE)}setMaterial(e){e!==this.material&&(this.material=e,this.lobe=xc(e),this.stretches=(e.table.stretches??[0,0,0]).map(Math.exp),gc(this.gl,this.rest,_c(e.table)))}setTexels(e){if(e===this.codes)return;this.codes=e;let{gl:t,texels:n}=this;this.texels=null,n!==null&&(t.deleteTexture(n.texture),t.deleteTexture(n.basis),n.program.delete()),this.texels=e&&hc(t,e)}uniforms(e,t){let{texels:n,sizes:r,table:i,rest:a,lobe:o,rotation:s,stretches:c}=this,l=n?Math.max(4,Math.round(bc*t)):Math.max(16,Math.round(r.samples*t)),u={samples:l,density:l*(e+1),footprint:1/Math.sqrt(e+1)};if(n){let t=ao(e*bc,[.5,.5,.5]);return{...u,start:t,codes:n.texture,functions:n.basis}}return{...u,table:i,rest:a,lobe:o,azimuths:r.azimuths,rotation:s,stretches:c}}},Cc=class{gl;many;frame;mean;surface;shaded;mirror;size=``;shading=``;constructor(e){this.gl=e}resize(e,t,n){let{gl:r}=this,{RGBA16F:i,RGBA32F:a,NEAREST:o}=r,s=`${e} ${t}`;if(s!==this.size){this.size=s;for(let e of[this.many,this.frame,this.mean])e?.delete();let n=r.getInternalformatParameter(r.RENDERBUFFER,i,r.SAMPLES),c=Math.min(4,Math.max(0,...n??[]));this.many=new Qo(r,e,t,[i],{samples:c,hasDepth:!0}),this.frame=new Qo(r,e,t,[i],{filter:o});let l=r.getExtension(`EXT_float_blend`)&&r.getExtension(`OES_texture_float_linear`);this.mean=new Qo(r,e,t,[l?a:i])}let c=`${s} ${n}`;if(c===this.shading)return;this.shading=c;for(let e of[this.surface,this.shaded,this.mirror])e?.delete();let[l,u]=[Math.ceil(e*n),Math.ceil(t*n)],d=[a,a,a,i];this.surface=new Qo(r,l,u,d,{filter:o,hasDepth:!0}),this.shaded=new Qo(r,l,u,[i],{filter:o}),this.mirror=new Qo(r,l,u,[i])}get uniforms(){let[e,t,n,r]=this.surface.textures;return{positions:e,normals:t,places:n,openings:r}}resolve(){let{gl:e,many:t,frame:n}=this,r=[0,0,n.width,n.height];e.bindFramebuffer(e.READ_FRAMEBUFFER,t.frame),e.bindFramebuffer(e.DRAW_FRAMEBUFFER,n.frame),e.blitFramebuffer(...r,...r,e.COLOR_BUFFER_BIT,e.NEAREST)}read(){let{width:e,height:t}=this.mean,n=this.mean.read(),r=new Float32Array(n.length);for(let i=0;i<t;i++)r.set(n.subarray(3*e*i,3*e*(i+1)),3*e*(t-1-i));return{width:e,height:t,pixels:r}}},wc=Xo($s,{"frame.glsl":Qs,"material.glsl":Is,"anisotropic.glsl":Xo(qs,{"basis.glsl":Ys})}),[Tc,Ec,Dc]=[.5,.25,4],Oc=class{canvas;gl;object;anisotropic=null;surface;paint;backdrop;blend;display;map;targets;ground;array;slots=[];buffers;mesh;lights=[];isPanorama=!1;constructor(e){this.canvas=e;let t=Yo(e);this.gl=t,t.depthFunc(t.LEQUAL),this.object=new Z(t,wc);let n=Xo(nc,{"basis.glsl":Ys});this.surface=new Z(t,n,{},ec),this.paint=new Z(t,tc,{},ec),this.backdrop=new Z(t,Js),this.blend=new Z(t,Xs),this.display=new Z(t,Zs),this.map=new ds(t,this.isSoftware),this.targets=new Cc(t),this.ground=new Ks(t),this.array=t.createVertexArray();let r=()=>t.createBuffer();this.buffers=[r(),r(),r(),r()],this.mesh=ua(`ball`),this.uploadMesh()}setMesh(e){e!==this.mesh&&(this.mesh=e,this.ground.setShadows(new Uint8Array),this.uploadMesh())}setOcclusion({openings:e,shadows:t}){let{gl:n}=this;this.ground.setShadows(t),n.bindVertexArray(this.array),n.bindBuffer(n.ARRAY_BUFFER,this.buffers[3]),n.bufferData(n.ARRAY_BUFFER,e,n.STATIC_DRAW),n.enableVertexAttribArray(4),n.vertexAttribPointer(4,4,n.FLOAT,!1,0,0),n.bindVertexArray(null)}setEnvironment(e,t){this.isPanorama=e===`own`&&t!==null,t!==null&&this.isPanorama?(this.map.drawPanorama(t.panorama),this.lights=t.lights):(this.map.drawFormula(e),this.lights=ls(e)),this.ground.changed()}material(e){return this.slots[e]??=new Sc(this.gl),this.slots[e]}get isSoftware(){let{gl:e}=this,t=e.getExtension(`WEBGL_debug_renderer_info`),n=t?String(e.getParameter(t.UNMASKED_RENDERER_WEBGL)):``;return/swiftshader|llvmpipe|software|basic render/i.test(n)}pixels({comparison:e}){return this.canvas.width*this.canvas.height*(e===`difference`?2:1)}*drawFrame(e,t,n,r,i){let{gl:a,targets:o,mesh:s}=this,{height:c}=this.canvas,l=this.canvas.width;o.resize(e.comparison===`difference`?2*l:l,c,n),this.ground.light(this.map,this.lights,kc(e),s.width/ca(s));let{count:u,column:d,row:f}=e.part??rc;for(let p of ac(e,u*l,l)){let m=this.slots[p.slot],h=e=>Math.min(Math.max(e-d*l,0),l),[g,_]=[h(p.from),h(p.to)];if(!m||g===_)continue;let v=[p.offset+p.x-d*l,-f*c,p.width,u*c],y=[p.offset+g,0,_-g,c],b=oc(t),x=([,,t,n])=>zs(s,e.view,p.width/(u*c),[2*b[0]/t,2*b[1]/n]),S=(e,t,n)=>{e.bind(),a.enable(a.SCISSOR_TEST),a.viewport(...t),a.scissor(...n),a.clear(a.COLOR_BUFFER_BIT|a.DEPTH_BUFFER_BIT)},C=x(v),w=[Tc*Math.max(n,.5),n].map((e,t)=>{let n=v.map(t=>Math.round(t*e)),r=[n[2]/v[2],n[3]/v[3]],i=[0,1].map(e=>n[e]+b[e]-(v[e]+b[e])*r[e]);return{coarse:n,part:ic(y,e,t===1?2:Dc),map:[...i,...r]}}),T=C.eye[2]>0;for(let[n,{coarse:c,part:l}]of[!0,!1].map((e,t)=>[e,w[t]])){if(n&&!T)continue;let u=n?Bs(x(c)):x(c);S(o.surface,c,l),a.frontFace(n?a.CW:a.CCW);let d=m.codes?.texture.toTexture??[0,0,0,0,0,0];this.surface.use({projection:u.projection,toTexture:d}),this.drawMesh(),a.frontFace(a.CCW);let[f,p,h,g]=l,_=n?Math.ceil(i/4):i;for(let l=0;l<_;l++){let[d,v]=[l,l+1].map(e=>Math.round(g*e/_));S(n?o.mirror:o.shaded,c,[f,p+d,h,v-d]);let y=n?.7*s.halfHeight:0;this.shade(u,e,m,t,n?Ec*r:r,y),a.disable(a.SCISSOR_TEST),i>1&&(yield)}}S(o.many,v,y),this.drawPaint(C,w[1].map),this.drawBackdrop(C,e,T?w[0].map:null),a.disable(a.SCISSOR_TEST)}this.gather(e,t)}gather(e,t){let{gl:n,targets:r}=this;r.resolve(),r.mean.bind(),n.blendColor(0,0,0,2/(t+2)),t>0&&n.enable(n.BLEND),n.blendFunc(n.CONSTANT_ALPHA,n.ONE_MINUS_CONSTANT_ALPHA),this.blend.cover({frame:r.frame.textures[0]}),n.disable(n.BLEND),this.show(e)}draw(e,t=1,n=1){this.drawFrame(e,0,t,n,1).next()}show(e){let{gl:t}=this;t.bindFramebuffer(t.FRAMEBUFFER,null),t.viewport(0,0,this.canvas.width,this.canvas.height),this.drawDisplay(e,e.comparison===`difference`?e.scale:0)}drawDisplay({exposure:e,tone:t,background:n},r){let i=n.startsWith(`#`),a=[1,3,5].map(e=>Number.parseInt(n.slice(e,e+2),16));this.display.cover({picture:this.targets.mean.textures[0],exposure:2**e,tone:_i.indexOf(t),behind:i?[...a.map(e=>e/255),1]:[0,0,0,0],scale:r})}difference(e){let{gl:t}=this,{frame:n}=this.targets,r=n.width>>1;n.bind(),t.viewport(0,0,r,n.height),this.drawDisplay(e,-1);let[i,a,o]=[0,0,0],s=n.read(r);for(let e=0;e<s.length;e+=3)s[e]>0&&(i+=s[e],a++,o=Math.max(o,s[e]));return{mean:i/Math.max(a,1),largest:o}}async finished(){let{gl:e}=this,t=performance.now(),n=e.fenceSync(e.SYNC_GPU_COMMANDS_COMPLETE,0);if(e.flush(),n===null)return 0;for(;!e.isContextLost();){let r=e.clientWaitSync(n,0,0);if(r===e.ALREADY_SIGNALED||r===e.CONDITION_SATISFIED||r===e.WAIT_FAILED)break;let i=Math.min(2+.1*(performance.now()-t),50);await new Promise(e=>setTimeout(e,i))}return e.deleteSync(n),performance.now()-t}get isLost(){return this.gl.isContextLost()}dispose(){this.gl.getExtension(`WEBGL_lose_context`)?.loseContext()}drawBackdrop(e,t,n){let{gl:r,backdrop:i,mesh:a,map:o,isPanorama:s}=this;r.enable(r.DEPTH_TEST),i.cover({...e,turn:kc(t),isPlain:t.background!==`environment`,isPanorama:s,size:[a.width,ca(a)],toMirror:n??[0,0,0,0],environment:o.texture,irradiance:o.irradiance,ground:this.ground.texture,mirror:this.targets.mirror.textures[0]}),r.disable(r.DEPTH_TEST)}drawPaint({projection:e},t){let{gl:n,targets:r}=this,i=r.shaded.textures[0],a=.02*this.mesh.radius;this.paint.use({projection:e,shaded:i,...r.uniforms,toShaded:t,near:a}),n.enable(n.CULL_FACE),n.polygonOffset(2,2),n.cullFace(n.BACK),this.drawMesh(),n.enable(n.POLYGON_OFFSET_FILL),n.cullFace(n.FRONT),this.drawMesh(),n.disable(n.POLYGON_OFFSET_FILL),n.disable(n.CULL_FACE)}drawMesh(){let{gl:e}=this;e.bindVertexArray(this.array),e.enable(e.DEPTH_TEST),e.drawElements(e.TRIANGLES,this.mesh.faces.length,e.UNSIGNED_INT,0),e.disable(e.DEPTH_TEST),e.bindVertexArray(null)}shade({eye:e},t,n,r,i,a){let{map:o}=this;(n.texels?.program??this.programOf(n)).cover({...n.uniforms(r,i),...this.targets.uniforms,...Hs(this.lights),eye:e,turn:kc(t),side:256,fade:a,environment:o.texture,irradiance:o.irradiance})}programOf({isAnisotropic:e}){return e?(this.anisotropic??=new Z(this.gl,wc,{ANISOTROPIC:1}),this.anisotropic):this.object}uploadMesh(){let{gl:e}=this;e.bindVertexArray(this.array),e.bindBuffer(e.ARRAY_BUFFER,this.buffers[0]),e.bufferData(e.ARRAY_BUFFER,this.mesh.vertices,e.STATIC_DRAW),e.bindBuffer(e.ELEMENT_ARRAY_BUFFER,this.buffers[1]),e.bufferData(e.ELEMENT_ARRAY_BUFFER,this.mesh.faces,e.STATIC_DRAW),[3,3,2].forEach((t,n)=>{e.enableVertexAttribArray(n),e.vertexAttribPointer(n,t,e.FLOAT,!1,32,12*n)}),e.bindBuffer(e.ARRAY_BUFFER,this.buffers[2]),e.bufferData(e.ARRAY_BUFFER,this.mesh.tangents,e.STATIC_DRAW),e.enableVertexAttribArray(3),e.vertexAttribPointer(3,3,e.FLOAT,!1,0,0),e.disableVertexAttribArray(4),e.vertexAttrib4f(4,0,0,0,1),e.bindVertexArray(null)}};function kc(e){let t=e.rotation*Math.PI/180;return[Math.cos(t),Math.sin(t)]}function Ac({width:e,height:t,pixels:n}){let r=jc(e,t),i=8*t,a=8+12*e,o=r.length+i,s=new Uint8Array(o+t*a);s.set(r);let c=new DataView(s.buffer);for(let i=0;i<t;i++){let t=o+i*a;c.setBigUint64(r.length+8*i,BigInt(t),!0),c.setInt32(t,i,!0),c.setInt32(t+4,a-8,!0),t+=8;for(let r of[2,1,0])for(let a=0;a<e;a++,t+=4)c.setFloat32(t,n[3*(i*e+a)+r],!0)}return s}function jc(e,t){let n=e=>[...new TextEncoder().encode(e),0],r=(...e)=>[...new Uint8Array(Int32Array.from(e).buffer)],i=(...e)=>[...new Uint8Array(Float32Array.from(e).buffer)],a=(e,t,i)=>[...n(e),...n(t),...r(i.length),...i],o=[`B`,`G`,`R`].flatMap(e=>[...n(e),...r(2,0,1,1)]),s=r(0,0,e-1,t-1);return Uint8Array.from([...r(20000630,2),...a(`channels`,`chlist`,[...o,0]),...a(`compression`,`compression`,[0]),...a(`dataWindow`,`box2i`,s),...a(`displayWindow`,`box2i`,s),...a(`lineOrder`,`lineOrder`,[0]),...a(`pixelAspectRatio`,`float`,i(1)),...a(`screenWindowCenter`,`v2f`,i(0,0)),...a(`screenWindowWidth`,`float`,i(1)),0])}var Mc=3840;function Nc(e,t,n,r,i){let{count:a,width:o,height:s}=Pc(e,t);return Pi(`Drawing the large picture`,async(e,t)=>{let c=Object.assign(document.createElement(`canvas`),{width:o,height:s}),l=document.createElement(`canvas`);[l.width,l.height]=[a*o,a*s];let u=new Oc(c);try{i(u);for(let i=0;i<a**2;i++){let[d,f]=[i%a,Math.floor(i/a)],p=e=>t((i+e)/a**2);await Fc(u,n,{...r,part:{count:a,column:d,row:f}},p,e),l.getContext(`2d`).drawImage(c,d*o,(a-1-f)*s)}return await Ic(l)}finally{u.dispose()}})}function Pc(e,{width:t,height:n}){if(e===`2x`)return{count:2,width:t,height:n};let r=Math.max(t,n),i=1;for(;Mc%i!==0||Mc/i>r;)i++;let a=e=>Math.max(Math.round(Mc/i/r*e),1);return{count:i,width:a(t),height:a(n)}}function Fc(e,t,n,r,i){return new Promise((a,o)=>{let s=new Ms(t,o);s.setRenderer(e),s.setShot(n),i.addEventListener(`abort`,()=>{s.setRenderer(null),o(new _t)}),tt(()=>{r(s.gathered.value),s.converged.value&&(e.isLost?o(new B(`The graphics driver has ended it; save it again.`)):a())})})}async function Ic(e){let t=await new Promise(t=>e.toBlob(t));if(t===null)throw new B(`The browser cannot save so large a picture; make the window smaller.`);return t}var Lc=R(!1),Rc=R(``),zc=R(!0),Bc=class{cores;slots;painter;mesh;shot=z(()=>{let{view:e,rotation:t,exposure:n,tone:r,background:i,comparison:a,edge:o,scale:s}=K.value;return{view:e,rotation:t,exposure:n,tone:r,background:i,comparison:a,edge:o,scale:s,slot:K.value.active}});renderer=null;canvas=null;constructor(e){this.cores=e;let t=t=>new ys(e,{changed:()=>this.painter.refresh(),failed:X,incidence:()=>{let{plots:e,active:n,incidence:r}=K.peek();return e&&n===t?r:null}});this.slots=[t(0),t(1)],this.painter=new Ms(this.slots,X);let n=z(()=>`${K.value.object} ${K.value.mesh}`);this.mesh=z(()=>(n.value,Bo(K.peek()).mesh)),this.bind()}attach(e){this.canvas=e;let t=e=>{e.preventDefault(),this.renderer=null,this.painter.setRenderer(null),Rc.value=`The graphics driver has taken the picture away; it returns as soon as the driver allows.`},n=new AbortController;e.addEventListener(`webglcontextlost`,t,{signal:n.signal}),e.addEventListener(`webglcontextrestored`,this.start,{signal:n.signal});let r=new ResizeObserver(()=>this.fit());return r.observe(e),this.fit(),this.start(),()=>{r.disconnect(),n.abort()}}start=()=>{if(this.canvas!==null){try{this.renderer=new Oc(this.canvas),Rc.value=``}catch(e){if(!(e instanceof Jo))throw e;Rc.value=e.message;return}this.show(this.mesh.peek()),this.renderer.setEnvironment(K.peek().environment,Vo(K.peek())),this.painter.setRenderer(this.renderer)}};show(e){this.renderer?.setMesh(e),this.painter.refresh(),Lc.value=!0;let t=()=>e===this.mesh.peek();this.painter.ready=Uo(e).then(e=>{t()&&this.renderer?.setOcclusion(e)}).catch(e=>X(e,()=>this.show(this.mesh.peek()))).finally(()=>{t()&&(Lc.value=!1)})}async radiance(){return(await this.whole()).targets.read()}async whole(){return Y({turntable:!1}),await Uo(this.mesh.peek()),this.painter.whole()}async picture(){return await this.whole(),Ic(this.canvas)}async largePicture(e){let t=await this.whole(),n=this.mesh.peek(),r=await Uo(n),{environment:i}=K.peek(),a=Vo(K.peek()),o=[this.slots[0].frozen(),this.slots[1].frozen()];return Nc(e,t.canvas,o,this.shot.peek(),e=>{e.setMesh(n),e.setOcclusion(r),e.setEnvironment(i,a)})}async scene(){if(this.renderer===null)throw Ns();let{renderer:e}=this,{view:t,rotation:n,environment:r}=K.peek(),{width:i,height:a}=e.canvas,o={mesh:this.mesh.peek(),view:t,rotation:n,width:i,height:a},s=Vo(K.peek());if(s!==null){let e=new Uint8Array(await s.file.arrayBuffer()),t=/\.exr$/i.test(s.file.name)?`exr`:`hdr`;return{...o,environment:{suffix:t,bytes:e},lights:[]}}let c=Ac(e.map.panoramaOf(r));return{...o,environment:{suffix:`exr`,bytes:c},lights:ls(r)}}fit(){if(this.canvas===null)return;let e=Math.min(window.devicePixelRatio||1,2),t=Math.max(1,Math.round(this.canvas.clientWidth*e)),n=Math.max(1,Math.round(this.canvas.clientHeight*e));(t!==this.canvas.width||n!==this.canvas.height)&&(this.canvas.width=t,this.canvas.height=n,this.painter.refresh())}bind(){let{slots:e,painter:t}=this,n=z(()=>K.value.materials),r=z(()=>K.value.comparison!==`off`),i=z(()=>K.value.active);tt(()=>{for(let t of[0,1])if(r.value||t===i.value){let r=Xc(n.value[t]);r!==null&&e[t].show(r)}});let a=z(()=>JSON.stringify(this.shot.value));tt(()=>{a.value,t.setShot(this.shot.peek())}),tt(()=>{let e=this.mesh.value;this.show(e),Bo(K.peek()).isMissing&&X(new B(jo(`mesh “${K.peek().mesh}”`)))});let o=z(()=>K.value.environment),s=z(()=>Vo(K.value));tt(()=>{let[e,n]=[o.value,s.value];this.renderer?.setEnvironment(e,n),t.refresh(),e===`own`&&n===null&&X(new B(jo(`panorama “${K.peek().panorama}”`)))});let c=z(()=>K.value.incidence),l=z(()=>K.value.plots);tt(()=>{c.value,l.value,e[i.value].drawPlane().catch(X)}),tt(()=>{t.converged.value&&Li(`The picture has converged.`)})}},Vc=R(null);async function Hc(){for(;Vc.peek()===null;)await new Promise(e=>setTimeout(e,100));return Vc.peek()}var Uc=So(()=>To());async function Wc(e){zc.value=!0;try{let[t,n]=await Promise.all([Uc(),Gc()]);`texture`in n&&await Mo(await Kc(String(n.texture)),t),`table`in n&&No(Fo(await Kc(String(n.table)))),`materials`in n&&!e&&Yi(()=>Ci(n),!1),Vc.value=new Bc(new Co(t))}catch(t){X(t,()=>void Wc(e))}finally{zc.value=!1}}async function Gc(){let e=await Ct(`start.json`);return e===null?{}:JSON.parse(new TextDecoder().decode(e))}async function Kc(e){let t=await Ct(e);if(t===null)throw new B(`The file ${e} is missing beside the page.`);return t}var qc=R([]),Jc=So(async()=>{let{isotropic:e}=(await Hc()).cores,{stored:t={}}=await Gc();for(let[n,r]of Object.entries(t).slice(qc.value.length)){let{bottom:t}=Go(new At(await Kc(r)),e);qc.value=[...qc.value,{name:n,bottom:t,coats:[],solo:null}]}});async function Yc(){try{return await Jc(),!0}catch(e){return X(e,()=>void Yc()),!1}}function Xc(e){let{bottom:t,rotation:n=0}=e;if(t.kind!==`texels`){let t=Er(e);return{stack:t,rotation:n,texture:null,table:Zc(e,t)}}let r=Do.get(t.texture);return r===void 0?(X(new B(jo(`texture of “${e.name}”`))),null):{stack:{bottom:{kind:`codes`,latents:In(r.texture)},coats:[]},rotation:0,texture:r}}function Zc({bottom:e,name:t},{coats:n}){if(e.kind!==`codes`||e.table===void 0||n.length>0)return;let{table:r,besideLobe:i=!1}=e,a=Oo.get(r);if(a!==void 0)return{logs:a,besideLobe:i};Yc().then(e=>{e&&Oo.get(r)===void 0&&X(new B(`${jo(`table of “${t}”`)} It is shown by its codes.`))})}var Qc=[`obj`,`glb`,`gltf`,`ply`],$c=R([]);async function el(e){Mi.value=null;for(let t of e)try{await tl(t)}catch(e){X(e,()=>void el([t]),`“${t.name}” was not opened. `)}}async function tl(e){await rl(e.slice(0,1));let t=e.name.toLowerCase().split(`.`).pop();if(t===`hdr`||t===`exr`){let n=await rl(e),r=await Pi(`Reading the panorama`,e=>wo(`readPanorama`,[n,t],[n.buffer],e));Ro(e.name,{file:e,...r})}else if(Qc.includes(t)){let n=await rl(e),r=await Pi(`Reading the mesh`,e=>wo(`readMesh`,[n,t],[n.buffer],e));Lo(e.name,r)}else if(t===`json`)J(Ci(ol(await rl(e))));else if(t===`safetensors`){let t=Vc.value?.cores;if(t===void 0)throw new B(`The networks are not loaded yet.`);let n=Bn(`Material`)(e.name.replace(/\.[a-z]+$/i,``)),r={name:n,...await il(t,await rl(e)),coats:[],solo:null};$c.value=[r,...$c.value.filter(e=>e.name!==n)],Wi(r)}else throw new B(nl(t,e.name))}function nl(e,t){return e===`binary`||e===`bsdf`?`Python encodes measured BRDFs: run urushi view ${t}.`:e===`mtlx`?`Python reads MaterialX: run urushi convert, and urushi view with the scene that it writes.`:`The page opens materials (.safetensors), panoramas (.hdr, .exr), meshes (.obj, .glb, .gltf, .ply) and saved states (.json).`}async function rl(e){try{return new Uint8Array(await e.arrayBuffer())}catch{throw new B(`It is a folder, or the browser cannot read it.`)}}async function il(e,t){let n=e.isotropic,r=new At(t);return Nn(r)?{bottom:{kind:`texels`,texture:await Mo(t,n)}}:Go(r,r.description.weights===n.fingerprint?n:await e.anisotropic())}function al(e){e.addEventListener(`dragover`,t=>{t.preventDefault(),e.classList.add(`dropping`)}),e.addEventListener(`dragleave`,t=>{t.relatedTarget===null&&e.classList.remove(`dropping`)}),e.addEventListener(`drop`,t=>{t.preventDefault(),e.classList.remove(`dropping`);let n=[...t.dataTransfer?.files??[]];n.length>0?el(n):X(new B(`What was dropped is no file; save it as a file, and drop that.`))})}function ol(e){try{return JSON.parse(new TextDecoder(`utf-8`,{fatal:!0}).decode(e))}catch{throw new B(`It is no JSON text.`)}}var sl=`u2`;function cl(e,t){return JSON.stringify(e,(e,t)=>t instanceof Float32Array?Array.from(t,e=>Number(e.toPrecision(8))):t,t)}function ll(e){let t=new TextEncoder().encode(cl(e));return`${sl}.${dl(t)}.${fl(t)}`}function ul(e){let[t,n,r,...i]=e.replace(/^#/,``).split(`.`);if(t!==sl)throw new B(`The address was made by another version of this page.`);let a=i.length===0&&n&&r?pl(r):null;if(a===null||dl(a)!==n)throw new B(`The address is incomplete; copy it again, up to its end.`);return Ci(JSON.parse(new TextDecoder().decode(a)))}function dl(e){return An(e).toString(36)}function fl(e){let t=``;for(let n of e)t+=String.fromCharCode(n);return btoa(t).replaceAll(`+`,`-`).replaceAll(`/`,`_`).replace(/=+$/,``)}function pl(e){try{let t=atob(e.replaceAll(`-`,`+`).replaceAll(`_`,`/`));return Uint8Array.from(t,e=>e.charCodeAt(0))}catch{return null}}var ml=Symbol.for(`pv`),hl=0;Array.isArray;function Q(t,n,r,i,a,o){n||={};var s,c,l=n;if(`ref`in l&&typeof t!=`function`)for(c in l={},n)c==`ref`?s=n[c]:l[c]=n[c];var u={type:t,props:l,key:r,ref:s,__k:null,__:null,__b:0,__e:null,__c:null,constructor:ml,__v:--hl,__i:-1,__u:0};return(a||o)&&(u.__source=a,u.__self=o),e.vnode&&e.vnode(u),u}var gl={undo:`M6 3 3 6l3 3M3 6h6.5a3.5 3.5 0 0 1 0 7H6`,redo:`m10 3 3 3-3 3m3-3H6.5a3.5 3.5 0 0 0 0 7H10`,plus:`M8 3v10M3 8h10`,cross:`m4 4 8 8m0-8-8 8`,grip:`M6 4v.01M10 4v.01M6 8v.01M10 8v.01M6 12v.01M10 12v.01`,eye:`M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8ZM8 10a2 2 0 1 0 0-4 2 2 0 0 0 0 4Z`,hidden:`m2 2 12 12M6.5 3.700A6 6 0 0 1 8 3.5c4 0 6.5 4.5 6.5 4.5a12 12 0 0 1-2 2.5M4 5a12 12 0 0 0-2.5 3S4 12.5 8 12.5a6 6 0 0 0 2.5-.55`,down:`m4 6 4 4 4-4`,save:`M8 2v8m-3-3 3 3 3-3M3 12.5h10`,open:`M2.5 12.5v-9h4l1.5 2h5.5v7Z`,sliders:`M2 5h6m3 0h3M2 11h3m3 0h6M9.500 6.500a1.500 1.500 0 1 0 0-3 1.500 1.500 0 0 0 0 3ZM6.500 12.500a1.500 1.500 0 1 0 0-3 1.500 1.500 0 0 0 0 3Z`,swap:`M3 6h9.5L10 3.5M13 10H3.5L6 12.5`};function _l({name:e}){return Q(`svg`,{class:`icon`,viewBox:`0 0 16 16`,"aria-hidden":`true`,focusable:`false`,children:Q(`path`,{d:gl[e]})})}function $(e){return Q(`button`,{type:`button`,...e})}function vl({name:e,icon:t,pressed:n,children:r,...i}){return Q($,{...i,class:`icon-button ${i.class??``}`,"aria-label":e,"aria-pressed":n,children:t?Q(_l,{name:t}):r})}function yl(e){let t=Math.min(Math.max(e,0),1);return t<=.0031308?12.92*t:1.055*t**(1/2.4)-.055}function bl(e){return e<=.04045?e/12.92:((e+.055)/1.055)**2.4}function xl(e){return`#${e.map(e=>Math.round(255*yl(e)).toString(16).padStart(2,`0`)).join(``)}`}function Sl(e){return G(t=>{let n=bl(Number.parseInt(e.slice(1+2*t,3+2*t),16)/255);return Number(n.toFixed(3))})}function Cl(e){let{name:t,value:n,options:r,onChange:i}=e;return Q(`select`,{"aria-label":t,value:n,onChange:({currentTarget:e})=>i(r[e.selectedIndex][0]),children:r.map(([e,t])=>Q(`option`,{value:e,children:t},e))})}function wl(e){let{name:t,value:n,options:r,onChange:i}=e;return Q(`div`,{class:`segments`,role:`group`,"aria-label":t,children:r.map(([e,t])=>Q($,{"aria-pressed":e===n,onClick:()=>i(e),children:t},e))})}function Tl({name:e,value:t,low:n,high:r,onChange:i}){let a=(e,a)=>{let o=Number.isFinite(a)?Math.min(Math.max(a,n),r):t;e.value=El(o),o!==t&&i(o)},o=e=>{let n=e.value.trim().replace(`,`,`.`);n!==El(t)&&a(e,n===``?NaN:Number(n))};return Q(`input`,{type:`text`,inputMode:`decimal`,class:`number`,autocomplete:`off`,spellcheck:!1,"aria-label":e,value:El(t),onInput:({currentTarget:e,inputType:t})=>{t.startsWith(`history`)&&o(e)},onFocus:({currentTarget:e})=>e.select(),onBlur:({currentTarget:e})=>o(e),onKeyDown:e=>{let{currentTarget:n,key:r}=e;r===`Enter`&&o(n),r===`Escape`&&(n.value=El(t));let i={ArrowUp:1,ArrowDown:-1}[r];if(i===void 0)return;e.preventDefault();let s=Math.abs(t),c=(s>=1?.1:s>=.1?.01:.001)*(e.shiftKey?10:1);a(n,Number((t+i*c).toFixed(4)))}})}function El(e){return String(Number(e.toPrecision(4)))}function Dl(e,t,n,r,i){let a={ArrowLeft:-1,ArrowDown:-1,ArrowRight:1,ArrowUp:1}[e.key],o={Home:r,End:i}[e.key];if(a!==void 0||o!==void 0)return e.preventDefault(),o??Math.min(Math.max(t+a*n,r),i)}var Ol=6;function kl({name:e,text:t,low:n,high:r,step:i,value:a,onInput:o,...s}){let c=Te(null),l=(e,t)=>{c.current=null,e.value=String(t),o(t)};return Q(`input`,{type:`range`,class:`${s.class??``} ${s.track?`graded`:``}`,"aria-label":e,"aria-valuetext":t,min:n,max:r,step:i,value:a,style:{"--fill":`${(100*(a-n)/(r-n)).toFixed(2)}%`,"--graded":s.track},onPointerDown:({pointerType:e,clientX:t,clientY:n})=>{c.current=e===`touch`?{x:t,y:n,value:a}:null},onInput:({currentTarget:e})=>{if(c.current===null)return o(Number(e.value));c.current.value=Number(e.value),e.value=String(a)},onPointerMove:({currentTarget:e,clientX:t,clientY:n})=>{if(c.current===null)return;let r=Math.abs(t-c.current.x);r>=Ol&&r>Math.abs(n-c.current.y)&&l(e,c.current.value)},onPointerUp:({currentTarget:e})=>{c.current!==null&&l(e,c.current.value)},onPointerCancel:()=>{c.current=null},onDblClick:s.onReset,onKeyDown:e=>{(e.key===`Delete`||e.key===`Backspace`)&&s.onReset()}})}var Al=[0,.2,.4,.6,.8,1];function jl(e){let{owner:t,parameter:n,value:r,coloured:i,aside:a,colourOf:o,onChange:s}=e,{isColour:c=!1}=n,l=W(r),u=`${t}, ${n.label}`,d=ut(!1),f=c?d.value:typeof r!=`number`,p=()=>s(n.fallback,``),m=(e,t)=>{if(e===null)return s(t,u);let n=[...l];n[e]=t,s(c?Wn(n):n,`${u} ${e}`)},h=()=>{c?d.value=!d.value:s(f?ri((l[0]+l[1]+l[2])/3):[...l],``)},g=e=>{if(o!==void 0)return`linear-gradient(90deg, ${Al.map(t=>{let r=ei(n,t);return xl(o(e===null?r:G(t=>t===e?r:l[t])))}).join(`, `)})`},_=e=>{let t=e===null?u:`${u}, ${Un[e]}`,r=l[e??0];return Q(`div`,{class:`row`,children:[Q(kl,{class:e===null?``:Un[e],track:g(e),name:t,text:String(r),low:0,high:500,step:1,value:ti(n,r),onInput:t=>m(e,ni(n,t,r)),onReset:p}),Q(Tl,{name:`${t}, number`,value:r,low:n.low,high:n.high,onChange:t=>m(e,t)})]},e)};return Q(`div`,{class:f?`field split`:`field`,children:[Q(`span`,{class:`label`,title:`${n.hint} Double click: reset.`,onDblClick:p,children:n.label}),Q(`span`,{class:`aside`,children:[a,i&&Q($,{class:`channels`,"aria-pressed":c?void 0:f,"aria-expanded":c?f:void 0,"aria-label":c?`${u}: channels`:`${u}: one value for each colour`,title:c?`The channels`:`One value for all colours, or for each`,onClick:h,children:[Q(`i`,{}),Q(`i`,{}),Q(`i`,{})]})]}),Q(`div`,{class:`rows`,children:[c&&Q(`input`,{type:`color`,class:`swatch`,"aria-label":`${u}: choose`,title:`Choose the colour`,value:xl(l),onInput:({currentTarget:e})=>s(Wn(Sl(e.value)),`${u} colour`)}),f?[0,1,2].map(_):!c&&_(null)]})]})}var Ml={...Si,view:{...Si.view,elevation:12,zoom:1.2},slot:0},Nl=new WeakMap,Pl=Promise.resolve(),Fl=0,Il=null;function Ll(e){let t=Nl.get(e);return t===void 0&&(Fl++,t=Pl.then(()=>Rl(e)).catch(()=>(Nl.delete(e),null)),Nl.set(e,t),Pl=t.then(()=>{--Fl>0||(Il?.dispose(),Il=null)})),t}async function Rl(e){let{cores:t}=await Hc(),n=Xc(e);if(n===null)return null;let{core:r,material:i}=await t.material(n),a=ms[r.widths],o=await r.table(i,{...a,shift:[0,0,0]});if(Il===null){let e=document.createElement(`canvas`);[e.width,e.height]=[112,112],Il=new Oc(e),Il.setEnvironment(`studio`,null)}let s=Il.material(0);return s.setTexels(n.texture),s.setTable(o,a,n.rotation,!0),Il.draw(Ml),createImageBitmap(Il.canvas)}function zl({of:e}){let t=Te(null);return we(()=>{let n=!0;return Ll(e).then(e=>{n&&e!==null&&t.current?.getContext(`2d`)?.drawImage(e,0,0)}),()=>{n=!1}},[e]),Q(`canvas`,{ref:t,width:112,height:112,"aria-hidden":`true`})}function Bl({owner:e,widths:t,onChange:n}){let{alpha:r,alphaV:i}=t;return typeof r!=`number`||i!==void 0?null:Q(jl,{owner:e,parameter:Vr,value:Hr(r),coloured:!1,onChange:(e,t)=>n({alpha:Ur(e)},t)})}function Vl({owner:e,parameter:t,widths:n,onChange:r}){let{alpha:i,alphaV:a}=n,o=a===void 0,s=Q($,{class:`link`,"aria-pressed":!o,"aria-label":`${e}, u·v: two widths`,title:o?`Two widths, along and across the tangent`:`One width`,onClick:()=>r({alpha:i,alphaV:o?i:void 0},``),children:`u·v`});return Q(x,{children:[Q(jl,{owner:e,parameter:o?t:{...Wr.alpha,fallback:t.fallback},value:i,coloured:typeof i!=`number`,aside:s,onChange:(e,t)=>r({alpha:e,alphaV:a},t)}),!o&&Q(jl,{owner:e,parameter:{...Wr.alphaV,fallback:t.fallback},value:a,coloured:typeof a!=`number`,onChange:(e,t)=>r({alpha:i,alphaV:e},t)})]})}function Hl(e,t){let{alphaV:n,...r}=e;return{...r,...yr(t)}}var Ul={metal:`Metal by index`,schlick:`Metal by reflectance`,diffuse:`Matt (Lambertian)`,dielectric:`Dielectric`};function Wl(){let{bottom:e,name:t,solo:n}=q.value,r=Jl(e),i=Ee(()=>({name:t,bottom:e,coats:[],solo:null}),[t,e]),a=(e,t=``)=>Wi({...q.value,bottom:e},t),o={owner:`Bottom`,widths:e,onChange:(t,n)=>a(Hl(e,t),n)},s=([t,n])=>Q(jl,{owner:`Bottom`,parameter:n,value:e[t],coloured:r!==`dielectric`,colourOf:n=>Sr({...e,[t]:n}),onChange:(n,r)=>a({...e,[t]:n},r)},t),c=Object.entries(Zr).filter(([t])=>t!==`alpha`&&t in e),l=c.filter(([,{isColour:e}])=>e),u=c.filter(([,{isColour:e}])=>!e);return Q(`section`,{class:`card bottom`,"aria-label":`Bottom`,style:{"--medium":xl(Sr(e))},children:[Q(`header`,{children:[Q(`span`,{class:`title`,children:`Bottom`}),Q(Cl,{name:`Kind of bottom`,value:r,options:[...Object.entries(Ul),...r===`codes`?[[`codes`,`Loaded material`]]:[],...r===`texels`?[[`texels`,`Loaded texture`]]:[]],onChange:t=>a(Xl(t,e))}),Q(vl,{class:`solo`,name:`Solo the bottom`,title:`Show the bottom without coats`,pressed:n===0,onClick:()=>Wi({...q.value,solo:n===0?null:0}),children:`S`})]}),Q(`div`,{class:`fields`,children:[r===`metal`&&Q(Kl,{bottom:e,onChange:a}),l.map(s),`alpha`in e&&Q(x,{children:[Q(Bl,{...o}),Q(`details`,{children:[Q(`summary`,{children:`Advanced`}),Q(Vl,{parameter:Zr.alpha,...o}),u.map(s)]})]}),(e.kind===`codes`||e.kind===`texels`)&&Q(`div`,{class:`loaded`,children:[Q(zl,{of:i}),Q(`p`,{class:`note`,children:[Q(`strong`,{children:t}),` `,Gl(e)]})]})]})]})}function Gl(e){if(e.kind===`texels`)return`was loaded from a file with a texture; coat it in Python. The plots show its mean code.`;let t=`was loaded from a file; its own coats keep their ratios of indices.`;return e.table===void 0?t:`${t} It is shown by its table, but under coats by its codes, which can differ from it by 10 to 40 %.`}function Kl({bottom:e,onChange:t}){let n=Object.entries(ai).find(([,t])=>`k`in e&&ql(W(e.eta),t.eta)&&ql(W(e.k),t.k));return Q(`div`,{class:`chips`,role:`group`,"aria-label":`Metals`,children:Object.entries(ai).map(([r,{eta:i,k:a}])=>Q($,{"aria-pressed":n?.[0]===r,style:{"--medium":xl(Sr({kind:`conductor`,alpha:0,eta:i,k:a}))},onClick:()=>t({kind:`conductor`,...Yl(e),eta:i,k:a}),children:r},r))})}function ql(e,t){return e.every((e,n)=>Math.abs(e-t[n])<1e-6)}function Jl(e){return e.kind===`conductor`?`r0`in e?`schlick`:`metal`:e.kind}var Yl=e=>yr(`alpha`in e?e:{alpha:Zr.alpha.fallback});function Xl(e,t){let n=Yl(t),r=Sr(t);switch(e){case`metal`:return{kind:`conductor`,...n,...ai.Gold};case`schlick`:return{kind:`conductor`,...n,r0:`k`in t?r:.9};case`dielectric`:return{kind:`dielectric`,...n,ior:1.5};case`diffuse`:return{kind:`diffuse`,reflectance:r};case`codes`:case`texels`:return t}}function Zl({card:e,name:t,dragged:n,onMove:r,onDrag:i}){let a=ut(!1),o=q.value.solo===e.id,s=(t,n)=>{let r=q.value.coats.map(n=>n.id===e.id?t:n);Wi({...q.value,coats:r},n)},c=(t,n=``)=>s({...e,...t},n),l=lr(e),u=xr(q.value,e),d=n=>{let r=t=>eu(e,n,t),i=$l(e,n);return Q(jl,{owner:t,parameter:Xr[n],value:i,coloured:n===`body`?typeof i!=`number`:n!==`thickness`,colourOf:n===`g`?void 0:e=>nu(r(e)),onChange:(e,t)=>s(r(e),t)})},f={owner:t,widths:e,onChange:(t,n)=>s(Hl(e,t),n)};return Q(`li`,{class:[`card`,Cr(q.value,e)?``:`unseen`,n?`dragged`:``].join(` `),"aria-label":t,style:{"--medium":xl(nu(e))},children:[Q(`header`,{children:[Q(vl,{class:`grip`,name:`Move ${t}: arrow keys, or drag`,title:`Drag, or use the arrow keys`,icon:`grip`,onPointerDown:i,onKeyDown:e=>{let t={ArrowUp:-1,ArrowDown:1}[e.key];if(t===void 0)return;e.preventDefault(),r(t);let n=e.currentTarget;requestAnimationFrame(()=>n.focus())}}),Q($,{class:`title`,"aria-expanded":!a.value,onClick:()=>{a.value=!a.value},children:[Q(`span`,{children:t}),Q(`small`,{children:tu(e,u)})]}),Q(vl,{class:`solo`,name:`Solo ${t}`,title:`Show this coat alone over the bottom`,pressed:o,onClick:()=>Wi({...q.value,solo:o?null:e.id}),children:`S`}),Q(vl,{class:`eye`,name:`Show ${t}`,title:e.on?`Switch off`:`Switch on`,icon:e.on?`eye`:`hidden`,pressed:e.on,onClick:()=>c({on:!e.on})}),Q(vl,{name:`Remove ${t}`,title:`Remove`,icon:`cross`,onClick:()=>{Wi(zr(q.value,e.id)),Li(`${t} was removed.`)}})]}),!a.value&&Q(`div`,{class:`fields`,children:[Q(jl,{owner:t,parameter:Yr,value:Gn(pr(l),ri),coloured:!0,colourOf:t=>nu(dr(e,t)),onChange:(t,n)=>s(dr(e,t),n)}),u?Q(Bl,{...f}):Q(`p`,{class:`note`,children:`No surface, so no gloss: its index n is that of the coat above.`}),d(`thickness`),d(`body`),Q(`details`,{children:[Q(`summary`,{children:`Advanced`}),d(`color`),d(`bodyColor`),u&&Q(Vl,{parameter:Xr.alpha,...f}),Q(jl,{owner:t,parameter:Xr.ior,value:e.ior,coloured:typeof e.ior!=`number`,onChange:(e,t)=>c({ior:e},t)}),d(`sigmaT`),d(`albedo`),d(`g`),Q(Ql,{card:e})]})]})]})}function Ql({card:e}){let{albedo:t,sigmaT:n}=cr(e),r={alpha:1,eta:1.5,albedo:t,g:e.g},i=[0,1,2].map(t=>{let i=W(n)[t]*(e.thickness??1),a=Ga({...r,sigmaT:i},t),o=mo(a);return o===a?null:ri(o.sigmaT)});return i.every(e=>e===null)?null:Q(`p`,{class:`note`,children:[`A medium that looks alike is shown, of depth `,[...new Set(i.filter(e=>e!==null))].join(`, `),`.`]})}function $l(e,t){return t===`thickness`?e.thickness??1:Gn({...lr(e),...cr(e),g:e.g}[t],ri)}function eu(e,t,n){if(t===`thickness`)return{...e,thickness:W(n)[0]};if(t===`g`)return{...e,g:n};if(t===`body`)return mr(e,n);let{color:r,body:i,bodyColor:a,albedo:o,sigmaT:s,...c}=e,l=t===`albedo`||t===`sigmaT`?cr(e):lr(e),u=Object.entries(l).map(([e,t])=>[e,Gn(t,ri)]);return{...c,...Object.fromEntries(u),[t]:n}}function tu(e,t){let{color:n,body:r}=lr(e),i=Math.max(...W(r)),a=Math.max(...W(e.alpha),...W(e.alphaV??e.alpha)),o=t?a>.2?`matt`:`glossy`:`no surface`;return i>.6?`${o}, opaque`:i>.02?`${o}, milky`:Math.min(...W(n))>.99?`${o}, clear`:`${o}, tinted`}function nu(e){return _r(e,e.thickness??1)}var ru=R(null);function iu(){let e=Te(null),{coats:t}=q.value,n=(e,n)=>{n<0||n>=t.length||e===n||(Wi(Lr(q.value,e,n),`move ${t[e].id}`),Li(`Coat moved to place ${n+1} of ${t.length}.`))},r=(t,n)=>{if(t.button!==0||e.current===null)return;let r=t.currentTarget;r.setPointerCapture(t.pointerId),ru.value=n.id;let i=`drag ${n.id} at ${t.timeStamp}`,a=t=>{let r=q.value.coats.findIndex(e=>e.id===n.id),a=[...e.current?.children??[]].map(e=>e.getBoundingClientRect()),o=a[r-1],s=a[r+1],c=a[r];c!==void 0&&(o&&t.clientY<o.top+Math.min(o.height/2,c.height)?Wi(Lr(q.value,r,r-1),i):s&&t.clientY>s.bottom-Math.min(s.height/2,c.height)&&Wi(Lr(q.value,r,r+1),i))},o=()=>{ru.value=null,r.removeEventListener(`pointermove`,a),r.removeEventListener(`lostpointercapture`,o)};r.addEventListener(`pointermove`,a),r.addEventListener(`lostpointercapture`,o)};return Q(`section`,{class:`cards`,"aria-label":`Stack of layers`,children:[Q(`div`,{class:`cards-head`,children:[Q(`h2`,{children:`Layers`}),Q($,{class:`quiet`,"aria-disabled":!Ir(q.value),title:Ir(q.value)?`Add a clear coat on top`:`Six coats are the most, and a texture of codes has none`,onClick:()=>{Ir(q.value)&&(Wi(Rr(q.value)),Li(`A coat was added on top.`))},children:[Q(_l,{name:`plus`}),` Add coat`]})]}),Q(`ul`,{ref:e,"aria-label":`Coats, the topmost first`,children:t.map((e,i)=>Q(Zl,{card:e,name:`Coat ${t.length-i}`,dragged:ru.value===e.id,onMove:e=>n(i,i+e),onDrag:t=>r(t,e)},e.id))}),Q(Wl,{}),(t.length>0||q.value.bottom.kind===`conductor`)&&Q(`label`,{class:`switch`,title:Pr(q.value)?`Light that meets a second facet of the topmost surface is given back`:`Materials of two widths, and bare ones but metals, have none`,children:[Q(`input`,{type:`checkbox`,disabled:!Pr(q.value),checked:q.value.energyCompensation===!0,onChange:({currentTarget:{checked:e}})=>Wi({...q.value,energyCompensation:e})}),`Energy compensation`]}),Mr(q.value)&&Q(`div`,{class:`fields tangent`,children:Q(jl,{owner:`Material`,parameter:Gr,value:q.value.rotation??0,coloured:!1,onChange:(e,t)=>Wi({...q.value,rotation:W(e)[0]},t)})})]})}var au=R(!1),ou=R(``),su=`Tap, point at or focus anything: its explanation appears here.`;function cu(e){let t=e.closest(`[title], .field`);return(t?.hasAttribute(`title`)?t:t?.querySelector(`.label`))?.getAttribute(`title`)??``}function lu(){return Q(vl,{class:`help`,name:`Explain the page`,title:`Explains what you tap, point at or focus`,pressed:au.value,onClick:()=>{au.value=!au.value,ou.value=su},children:`?`})}function uu(){return we(()=>{let e=({target:e})=>{au.value&&e instanceof Element&&(ou.value=cu(e)||su)},t=new AbortController;for(let n of[`pointerover`,`pointerdown`,`focusin`])document.addEventListener(n,e,{signal:t.signal});return()=>t.abort()},[]),Q(`p`,{class:`explanation`,role:`status`,hidden:!au.value,children:au.value&&ou.value})}function du(){let e=Vc.value?.slots[K.value.active];return Q(`section`,{class:`plots`,"aria-label":`Plots`,children:Q(`details`,{open:K.value.plots,onToggle:({currentTarget:e})=>{let{open:t}=e;t!==K.value.plots&&(Y({plots:t}),t&&e.scrollIntoView({block:`nearest`}))},children:[Q(`summary`,{children:`Plots`}),Q(`div`,{children:[Q(hu,{slot:e}),Q(yu,{slot:e})]})]})})}function fu({angles:e,values:t,place:n}){if(t===null)return null;let r=(e,t)=>n(e,t).map(e=>e.toFixed(1)).join(` `);return Un.map((n,i)=>{let a=Array.from(e,(e,n)=>r(e,t[3*n+i]));return Q(`path`,{class:`curve ${n}`,d:`M${a.join(`L`)}`},n)})}var pu=120;function mu(e){let t=Math.max(1,...e??[]),n=10**Math.ceil(Math.log10(t)-.02),r=.01,i=e=>pu*Math.log(1+Math.max(e,0)/r)/Math.log(1+n/r),a=[];for(let e=n;e>.05;e/=10)a.push(Number(e.toPrecision(1)));return{radius:i,rings:a}}function hu({slot:e}){let t=Te(null),n=Te(null),r=Te(!1),{incidence:i}=K.value,a=e?.plane.value??null,{radius:o,rings:s}=mu(a),c=(e,t)=>{let n=e*Math.PI/180;return[t*Math.sin(n),-t*Math.cos(n)]},[l,u]=c(-i,pu),d=e=>{let n=t.current?.getScreenCTM();if(!n)return;let r=new DOMPoint(e.clientX,e.clientY).matrixTransform(n.inverse()),i=Math.atan2(-r.x,Math.max(-r.y,0))*180/Math.PI;Y({incidence:Math.round(Math.min(Math.max(i,0),89))})};return Q(`figure`,{children:[Q(`figcaption`,{children:[Q(`b`,{children:`f in the plane of incidence`}),` [1/sr]`]}),Q(`svg`,{ref:t,viewBox:`-150 -136 300 152`,role:`group`,"aria-label":`Plot of f in the plane of incidence`,onPointerDown:e=>{r.current=e.pointerType!==`touch`||e.target===n.current,r.current&&(e.currentTarget.setPointerCapture(e.pointerId),d(e))},onPointerMove:e=>{r.current&&d(e)},onLostPointerCapture:()=>{r.current=!1},children:[Q(`g`,{class:`grid`,children:[s.map(e=>Q(`g`,{children:[Q(`path`,{d:gu(o(e))}),Q(`text`,{x:o(e)-2,y:11,"text-anchor":`end`,children:e})]},e)),Q(`path`,{d:`M-120 0H${pu}M0 0V-120`})]}),Q(fu,{angles:_s,values:a,place:(e,t)=>c(e,o(t))}),Q(`line`,{class:`incident`,x1:0,y1:0,x2:l,y2:u}),Q(`circle`,{class:`knob`,cx:l,cy:u,r:7}),Q(`circle`,{ref:n,class:`handle`,cx:l,cy:u,r:14,tabindex:0,role:`slider`,"aria-label":`Angle of incidence`,"aria-valuemin":0,"aria-valuemax":89,"aria-valuenow":i,"aria-valuetext":`${i} degrees`,onKeyDown:e=>{let t=Dl(e,i,e.shiftKey?-10:-1,0,89);t!==void 0&&Y({incidence:t})}}),Q(`text`,{class:`value`,x:l<-60?l+4:l-12,y:u-11,"text-anchor":`middle`,children:[i,`°`]})]})]})}function gu(e){let t=e.toFixed(1);return`M-${t} 0A${t} ${t} 0 0 1 ${t} 0`}var _u=230,vu=104;function yu({slot:e}){let t=e?.albedo.value??null,{incidence:n}=K.value,r=e=>_u*e/90;return Q(`figure`,{children:[Q(`figcaption`,{children:[Q(`b`,{children:`Directional albedo`}),` by angle of incidence`]}),Q(`svg`,{viewBox:`-34 -14 280 142`,role:`img`,"aria-label":bu(t),children:[Q(`g`,{class:`grid`,children:[[0,.25,.5,.75,1].map(e=>Q(`path`,{d:`M0 ${vu*(1-e)}H${_u}`},e)),[0,.5,1].map(e=>Q(`text`,{x:-6,y:vu*(1-e)+3,"text-anchor":`end`,children:e},e)),[0,30,60,90].map(e=>Q(`text`,{x:r(e),y:119,"text-anchor":`middle`,children:[e,`°`]},e))]}),Q(`line`,{class:`incident`,x1:r(n),x2:r(n),y1:0,y2:vu}),Q(fu,{angles:hs,values:t,place:(e,t)=>[r(e),vu*(1-Math.min(t,1.1))]})]})]})}function bu(e){if(e===null)return`Directional albedo`;let t=t=>[0,1,2].map(n=>`${Math.round(100*e[3*t+n])}`).join(`, `);return`Directional albedo in percent, red, green and blue: ${t(0)} near the normal, ${t(13)} at grazing incidence`}var xu=`stage`;function Su(){let{comparison:e,materials:t,background:n}=K.value;return Q(`section`,{id:xu,class:n===`transparent`?`stage checkered`:`stage`,"aria-label":`Picture`,children:[Q(wu,{}),(e===`side`||e===`swipe`)&&Q(`div`,{class:`names ${e}`,children:[Q(`span`,{children:[`A · `,fi(t[0])]}),Q(`span`,{children:[`B · `,fi(t[1])]})]}),e===`swipe`&&Q(Pu,{}),e===`difference`&&Q(Mu,{}),Rc.value===``?Q(ju,{}):Q(`p`,{class:`missing`,children:Rc.value}),Q(Cu,{})]})}function Cu(){if(Mi.value===null)return null;let{text:e,retry:t}=Mi.value,n=()=>{Mi.value=null};return Q(`div`,{class:`notice`,role:`alert`,children:[Q(`span`,{children:e}),t&&Q($,{onClick:()=>{n(),t()},children:`Try again`}),Q($,{onClick:n,children:`Close`})]})}function wu(){let e=Te(null),{current:t}=Te(new Map),n=Vc.value;we(()=>e.current&&n?n.attach(e.current):void 0,[n]),we(()=>{let t=e.current,n=e=>{e.preventDefault();let t=e.deltaY*(e.ctrlKey?6:1);Ou({zoom:K.value.view.zoom*2**(-t/600)})};return t.addEventListener(`wheel`,n,{passive:!1}),()=>t.removeEventListener(`wheel`,n)},[]);let{object:r,mesh:i,environment:a,turntable:o,comparison:s,materials:c,active:l}=K.value,u=s===`off`?fi(c[l]):`${fi(c[0])} beside ${fi(c[1])}`;return we(()=>{if(!o)return;let e=setInterval(()=>{Du()?Y({turntable:!1}):t.size===0&&Ou({azimuth:K.value.view.azimuth+Tu})},Eu);return()=>clearInterval(e)},[o,t]),Q(`canvas`,{ref:e,tabIndex:0,role:`img`,"aria-label":`${r===`own`?i:`A ${r}`} of ${u}, lit by the environment “${a}”. Arrow keys turn the camera, with Control they shift the picture, with Shift they turn the light; plus and minus zoom; Home or a double click resets the camera.`,onContextMenu:e=>e.preventDefault(),onPointerDown:({button:e,currentTarget:n,pointerId:r,clientX:i,clientY:a})=>{e!==1&&(n.setPointerCapture(r),t.set(r,[i,a]))},onLostPointerCapture:({pointerId:e})=>t.delete(e),onPointerMove:e=>{let{pointerId:n,clientX:r,clientY:i,currentTarget:a}=e,o=t.get(n);if(o===void 0)return;let{view:s}=K.value,[c,l]=[r-o[0],i-o[1]];t.set(n,[r,i]);let u=e=>{let t=e*2/(a.clientHeight*s.zoom);return[s.pan[0]+c*t,s.pan[1]-l*t]},d=[...t].find(([e])=>e!==n)?.[1];if(d!==void 0){let e=e=>Math.hypot(e[0]-d[0],e[1]-d[1])+1;Ou({zoom:s.zoom*e([r,i])/e(o),pan:u(.5)})}else e.buttons!==1||e.ctrlKey||e.metaKey?Ou({pan:u(1)}):e.shiftKey?ku(c*.4):Ou({azimuth:s.azimuth-c*.4,elevation:s.elevation+l*.3})},onDblClick:()=>Y({view:Si.view}),onKeyDown:e=>{let{view:t}=K.value,n=e.ctrlKey||e.metaKey;if(e.altKey||n&&!e.key.startsWith(`Arrow`))return;e.key===`Home`&&Y({view:Si.view});let r={ArrowLeft:-1,ArrowRight:1}[e.key],i={ArrowUp:1,ArrowDown:-1}[e.key],a={"+":1.1,"=":1.1,"-":1/1.1}[e.key],[o,s]=t.pan;if((r??i)!==void 0&&n)Ou({pan:[o+.1*(r??0),s+.1*(i??0)]});else if(r!==void 0&&e.shiftKey)ku(5*r);else if(r!==void 0)Ou({azimuth:t.azimuth+5*r});else if(i!==void 0)Ou({elevation:t.elevation+5*i});else if(a!==void 0)Ou({zoom:t.zoom*a});else return;e.preventDefault()}})}var[Tu,Eu]=[.6,40];function Du(){return matchMedia(`(prefers-reduced-motion: reduce)`).matches}function Ou(e){let{azimuth:t,pan:n,...r}={...K.value.view,...e},i=n.map(e=>Number(e.toFixed(3)));Y({view:bi({...r,azimuth:Au(t),pan:i})})}function ku(e){J({rotation:Au(K.value.rotation+e)},`rotation`)}function Au(e){return Number(Kr(e).toFixed(1))}function ju(){let e=Vc.value?.painter;if(Ni.value!==null){let{text:e,share:t,cancel:n}=Ni.value;return Q(`p`,{class:`status`,children:[Q(`progress`,{"aria-label":e,value:t}),e,` …`,n&&Q($,{onClick:n,children:`Cancel`})]})}return e===void 0?Q(`p`,{class:`status`,children:zc.value?`Loading the networks …`:`The networks are not loaded.`}):Q(`p`,{class:`status`,"data-converged":e.converged.value&&!Lc.value,children:[Q(`progress`,{"aria-hidden":`true`,value:e.gathered.value}),Lc.value?`computing shadows`:e.converged.value?`converged`:`refining`]})}function Mu(){let{scale:e}=K.value,t=Vc.value?.painter.difference.value;return Q(`div`,{class:`legend`,children:[Q(`span`,{title:`Distance of the shown colours in CIELAB (CIE 1976); 2 is just seen`,children:`Colour difference`}),Q(`span`,{children:`0`}),Q(`div`,{class:`ramp`,"aria-hidden":`true`}),Q(`label`,{children:[Q(`span`,{class:`spoken`,children:`Largest difference`}),Q(Cl,{value:e,options:yi.map(e=>[e,e]),onChange:e=>Y({scale:e})})]}),t&&Q(`span`,{title:`Mean over the pixels that differ, and the largest difference`,children:[`mean `,t.mean.toFixed(1),`, largest `,t.largest.toFixed(1)]})]})}var Nu=.02;function Pu(){let{edge:e}=K.value;return Q(`div`,{class:`edge`,style:{left:`${100*e}%`},role:`slider`,tabIndex:0,"aria-label":`Edge between A and B`,"aria-orientation":`horizontal`,"aria-valuemin":0,"aria-valuemax":100,"aria-valuenow":Math.round(100*e),onPointerDown:e=>e.currentTarget.setPointerCapture(e.pointerId),onPointerMove:e=>{if(!e.currentTarget.hasPointerCapture(e.pointerId))return;let t=e.currentTarget.parentElement.getBoundingClientRect(),n=(e.clientX-t.left)/t.width;Y({edge:Math.min(Math.max(n,Nu),.98)})},onKeyDown:t=>{let n=Dl(t,e,.02,Nu,.98);n!==void 0&&Y({edge:n})}})}function Fu({label:e,hint:t,fallback:n=0,...r}){return Q(`label`,{title:t,children:[Q(`span`,{children:e}),Q(kl,{...r,onReset:()=>r.onInput(n)}),Q(`output`,{children:r.text})]})}var Iu={off:`Single`,side:`Side by side`,swipe:`Swipe`,difference:`Difference`};function Lu(){let{object:e,mesh:t,environment:n,panorama:r,rotation:i,exposure:a,comparison:o}=K.value,s=t===``?[...hi]:[...hi,`own`],c=gi.filter(e=>e!==`own`||r!==``);return Q(`div`,{class:`toolbar`,role:`toolbar`,"aria-label":`Scene`,children:[Q(`label`,{children:[Q(`span`,{children:`Object`}),Q(Cl,{value:e,options:s.map(e=>[e,e===`own`?t:Ru(e)]),onChange:e=>J({object:e})})]}),Q(`label`,{children:[Q(`span`,{children:`Light`}),Q(Cl,{value:n,options:c.map(e=>[e,e===`own`?r:Ru(e)]),onChange:e=>J({environment:e})})]}),Q(Fu,{label:`Turn`,hint:`Turns the light about the object. Double click: reset.`,text:`${Math.round(i)}°`,value:i,low:-180,high:180,step:1,onInput:e=>J({rotation:e},`rotation`)}),Q(Fu,{label:`Exposure`,hint:`Brightness of the picture in powers of two. Double click: reset.`,text:`${a>0?`+`:``}${a}`,value:a,low:-4,high:4,step:.1,onInput:e=>J({exposure:Number(e.toFixed(1))},`exposure`)}),Q(wl,{name:`Compare`,value:o,options:vi.map(e=>[e,Iu[e]]),onChange:e=>J({comparison:e})})]})}function Ru(e){return e[0].toUpperCase()+e.slice(1)}function zu({label:e,name:t,kind:n,children:r}){let i=ut(!1),a=Te(null),o=Te(null),s=()=>{i.value=!1,o.current?.focus()};return we(()=>{let e=e=>{a.current?.contains(e.target)||(i.value=!1)},t=new AbortController;return document.addEventListener(`pointerdown`,e,{signal:t.signal}),document.addEventListener(`focusin`,e,{signal:t.signal}),()=>t.abort()},[i]),Q(`div`,{class:`menu ${n}`,ref:a,onKeyDown:e=>{e.key===`Escape`&&i.value&&s()},children:[Q(`button`,{type:`button`,ref:o,class:`opener`,"aria-label":t,"aria-expanded":i.value,onClick:()=>{i.value=!i.value},children:e}),i.value&&Q(`div`,{class:`panel`,children:r(s)})]})}function Bu({onChosen:e}){let t=Te(null),n=Te(null),r=ut(``),i=ut(q.value.name);we(()=>{Yc(),t.current?.querySelector(`[tabindex='0']`)?.focus()},[]);let a=[...$c.value.map(e=>[`Opened`,e]),...li.map(e=>[di(e),e]),...qc.value.map(e=>[`Thin films`,e])].filter(([,{name:e}])=>e.toLowerCase().includes(r.value.toLowerCase())),o=a.find(([,{name:e}])=>e===i.value)??a[0],s=t=>{t!==void 0&&(Wi(t[1]),e())};return Q(`div`,{ref:t,onKeyDown:e=>{let{key:r}=e,i=[...t.current?.querySelectorAll(`button`)??[]],o=i.indexOf(document.activeElement),c={ArrowLeft:-1,ArrowRight:1}[r],l={ArrowUp:-1,ArrowDown:1}[r],u;if(e.target===n.current)r===`Enter`?(e.preventDefault(),s(a[0])):l===1&&(u=i[0]);else if(c!==void 0)u=i[o+c];else if(l!==void 0)u=Vu(i,i[o],l)??n.current;else if(r===`Home`)u=i[0];else if(r===`End`)u=i.at(-1);else if(r.length===1&&r!==` `&&!e.ctrlKey&&!e.metaKey)return n.current.focus();u&&(e.preventDefault(),u.focus())},children:[Q(`input`,{ref:n,type:`search`,class:`search`,placeholder:`Search`,"aria-label":`Search the materials`,value:r.value,onInput:({currentTarget:e})=>{r.value=e.value}}),[...new Set(a.map(([e])=>e))].map(e=>Q(`section`,{children:[Q(`h2`,{children:e}),Q(`ul`,{children:a.filter(([t])=>t===e).map(e=>Q(`li`,{children:Q($,{tabIndex:e===o?0:-1,"aria-pressed":e[1].name===q.value.name,onFocus:()=>{i.value=e[1].name},onClick:()=>s(e),children:[Q(zl,{of:e[1]}),Q(`span`,{children:e[1].name})]})},e[1].name))})]},e)),a.length===0&&Q(`p`,{class:`note`,children:`No material has this in its name.`})]})}function Vu(e,t,n){let{left:r,top:i}=t.getBoundingClientRect(),a=e=>{let t=e.getBoundingClientRect(),a=n*(t.top-i);return a<4?1/0:100*a+Math.abs(t.left-r)},o=e.reduce((e,t)=>a(t)<a(e)?t:e,t);return a(o)<1/0?o:void 0}var Hu={dds:`DDS`,npy:`NPY`,exr:`EXR`},[Uu,Wu,Gu]=er.SHAPE;function Ku(e,t){let n=e.length/(4*Uu*Wu);if(t===`exr`)return new Blob([Ac(Yu(e,n))]);let r=t===`dds`?qu(n):Ju(n);return new Blob([r,Po(e)])}function qu(e){let t=new Uint32Array(37);return t.set([542327876,124,8392719,Wu,e,8*e,Uu,1]),t.set([32,4,808540228],19),t.set([4096,2097152],27),t.set([10,4,0,1,0],32),new Uint8Array(t.buffer)}function Ju(e){let t=`{'descr': '<f2', 'fortran_order': False, 'shape': ${`(${Uu}, ${Wu}, ${e}, 4)`}, }`.padEnd(117);return Uint8Array.of(147,...new TextEncoder().encode(`NUMPY\0v\0`),...new TextEncoder().encode(`${t}\n`))}function Yu(e,t){let n=Math.ceil(4*t/Gu/3),r=new Float32Array(Uu*n*Gu*Wu*3);for(let i=0;i<Uu*Wu*Gu;i++){let[a,o]=[Math.floor(i/Gu),i%Gu],[s,c]=[Math.floor(a/Wu),a%Wu];for(let i=0;i<4*t/Gu;i++){let l=4*(a*t+Math.floor(i/4)*Gu+o)+i%4,u=(s*n*Gu+Math.floor(i/3)*Gu+o)*Wu+c;r[3*u+i%3]=e[l]}}return{width:n*Gu*Wu,height:Uu,pixels:r}}var Xu=1/7;function Zu(e){let{inputs:t,lost:n}=Qu(e),r=[`<?xml version="1.0"?>`,`<materialx version="1.39" colorspace="lin_rec709">`,`  <open_pbr_surface name="surface" type="surfaceshader">`,...Object.entries(t).map(([e,t])=>{let[n,r]=typeof t==`number`?[`float`,t]:[`color3`,t.join(`, `)];return`    <input name="${e}" type="${n}" value="${r}" />`}),`  </open_pbr_surface>`,`  <surfacematerial name="material" type="material">`,`    <input name="surfaceshader" type="surfaceshader" nodename="surface" />`,`  </surfacematerial>`,`</materialx>`,``].join(`
`),i=`The document leaves out what OpenPBR does not have: ${n.join(`, `)}.`;return{text:r,lost:n.length>0?i:``}}function Qu(e){let{bottom:t,coats:n}=wr(e),r=[],i=({id:t})=>`coat ${e.coats.length-e.coats.findIndex(e=>e.id===t)}`,[a,...o]=n,s=n.some(e=>Math.min(...gr(e,$u(e)))>=.5),c=Dr(t,Kn(n.at(-1)?.ior??Yn.AIR,Yn.AIR)),l=o.filter(t=>xr(e,t)),u;if(c.kind===`diffuse`||s&&c.kind!==`codes`){let e=n.reduceRight((e,t)=>_r(t===a?{...lr(t),color:1,g:0}:t,$u(t),e),Sr(c)),t=l.shift();u=t?nd(t,e,a.ior,r):ed({kind:`diffuse`,reflectance:e},r)}else{u=ed(c,r);let e=o.reduce((e,t)=>_r({...lr(t),body:0,g:0},$u(t),e),[1,1,1]),t=u.base_color;t?u.base_color=G(n=>t[n]*e[n]):e.some(e=>e!==1)&&r.push(`the colour of the lower coats`);for(let e of n)od(lr(e).body)>0&&r.push(`the body of ${i(e)} and its colour`)}return r.push(...l.map(e=>`the surface of ${i(e)}`)),a!==void 0&&Object.assign(u,{coat_weight:1,coat_color:W(Gn(lr(a).color,e=>e**$u(a))),...id(`coat`,a,r),coat_ior:ad(a.ior,`the coat's index of each channel`,r)}),Nr({bottom:t,coats:n})&&(e.rotation??0)!==0&&r.push(`the tangent's angle`),{inputs:u,lost:r}}function $u({thickness:e=1}){return e}function ed(e,t){switch(e.kind){case`diffuse`:return{base_color:W(e.reflectance),specular_weight:0};case`dielectric`:{let{specular_roughness:n}=id(`specular`,e,t);return{base_weight:0,specular_roughness:n,specular_ior:ad(e.ior,`the bottom's index of each channel`,t)}}case`codes`:throw new B(`A loaded material cannot be written as MaterialX; save the material, or its code.`)}return{...td(e),base_metalness:1,...id(`specular`,e,t)}}function td(e){if(`r0`in e)return{base_color:W(e.r0)};let[t,n]=[W(e.eta),W(e.k)],r=G(e=>or(1,t[e],n[e]));return{base_color:r,specular_color:G(e=>Math.min(or(Xu,t[e],n[e])/ar(r[e],1,Xu),1))}}function nd(e,t,n,r){let i=id(`specular`,e,r),a=ad(e.ior,`the bottom's index of each channel`,r),o=rd(a/od(n));return{base_color:W(Gn(t,e=>(1-o)*e/(1-e*o))),specular_weight:1,...i,specular_ior:a}}function rd(e){return e<=1?0:1-(1-(e-1)/(4.08567+1.00071*e))/(e*e)}function id(e,{alpha:t,alphaV:n},r){let[i,a]=[ad(t,`the ${e===`coat`?e:`bottom`}'s roughness of each channel`,r),od(n??t)];a>i&&r.push(`a width across the tangent above that along it`);let o=Math.min(a/i,1),s=a>i?Math.sqrt(i*a):i,c=Math.sqrt(2/(1+o*o));return{[`${e}_roughness`]:sd(Math.sqrt(s/c)),[`${e}_roughness_anisotropy`]:sd(1-o)}}function ad(e,t,n){return new Set(W(e)).size>1&&!n.includes(t)&&n.push(t),od(e)}function od(e){let[t,n,r]=W(e);return t===n&&n===r?t:(t+n+r)/3}function sd(e){return Number(e.toFixed(6))}function cd(e){let{name:t,rotation:n=0}=e,r=wr(e),i=r.coats.length===0,a=fd(r.bottom);i&&Fr(e)&&a.push([`energy_compensation`,!0]);let o=[`import numpy as np`,``,`import urushi`,``,`# The layers one by one by the layering network, as on the page. Without fast=True, light`,`# transport is computed, which takes longer and is closer to the random walk.`,`material = ${pd(`urushi.${r.bottom.kind}`,a)}`];for(let[t,n]of[...r.coats.entries()].reverse()){let i=([e])=>e===`ior`||e.startsWith(`alpha`),a=ud(n),s=pd(`urushi.dielectric`,a.filter(i)),c=a.filter(e=>!i(e));t===0&&Fr(e)&&c.push([`energy_compensation`,!0]),t===r.coats.length-1&&Nr(r)&&c.push([`weights`,`"anisotropic"`]),c.push([`fast`,!0]),o.push(`material = ${pd(`urushi.layer`,c,`${s}, material`)}`)}i&&o.push(`material = urushi.encode(material)`);let s=n!==0&&Nr(r)?`material.rotated(${n})`:``,c=`np.array([[0.5, 0.0, np.sqrt(0.75)]])`;return o.push(...s?[`material = ${s}`]:[],``,`print(material.f(${c}, ${c} * [-1, 1, 1]))  # 1/sr`,`material.save("${dd(t)}.safetensors")`,``),o.join(`
`)}var ld=`alpha alphaU alphaV ior r0 eta k reflectance albedo sigmaT color body bodyColor g thickness`.split(` `);function ud(e){let{alpha:t,...n}={thickness:1,...e},r={...n,[`alphaV`in e?`alphaU`:`alpha`]:t};return ld.filter(e=>r[e]!==void 0).filter(e=>e!==`thickness`||r.thickness!==1).map(e=>[e.replace(/[A-Z]/,e=>`_${e.toLowerCase()}`),r[e]])}function dd(e){return e.toLowerCase().replace(/[^a-z0-9]+/g,`-`).replace(/^-|-$/g,``)||`material`}function fd(e){if(e.kind===`codes`)throw new B(`A loaded material has no description; save its file, or the state as JSON.`);return ud(e)}function pd(e,t,n=``){let r=t.map(([e,t])=>`${e}=${md(t)}`);return`${e}(${[...n?[n]:[],...r].join(`, `)})`}function md(e){return e===!0?`True`:typeof e==`object`?`(${e.join(`, `)})`:String(e)}function hd(e){let{rotation:t=0}=e,n=wr(e),r=Nr(n)&&t!==0;if(r&&n.coats.length===0)throw new B(`Mitsuba turns no tangent of a bare surface; set the angle to 0, or save the material.`);if(Fr(e)&&n.coats.length===0)throw new B(`Mitsuba has no bare metal with energy compensation; switch that off, or save the material.`);let i=[...n.coats.map(gd),_d(n.bottom)];Fr(e)&&i[0][1].push([`energy_compensation`,!0]),r&&i[0][1].push([`rotation`,t]);let a=i.flatMap(([e,t],n)=>[`<bsdf type="${e}" ${n===0?`id="material"`:`name="bottom"`}>`,...t.map(([e,t])=>{let n=typeof t==`object`?t.join(`, `):t;return`    <${vd(e,t)} name="${e}" value="${n}"/>`})].map(e=>`    `.repeat(n)+e)),o=i.map((e,t)=>`${`    `.repeat(t)}</bsdf>`).reverse();return`${[...a,...o].join(`
`)}\n`}function gd(e){return[`neural_layered`,ud(e).map(([e,t])=>[e===`ior`?`int_ior`:e,t])]}function _d(e){let t=fd(e);if(e.kind===`diffuse`)return[`diffuse`,t];if(e.kind===`dielectric`)throw new B(`Mitsuba has no opaque dielectric; choose another bottom.`);return[`roughconductor`,[[`distribution`,`ggx`],...t.flatMap(([e,t])=>e===`r0`?[[`material`,`none`],[`specular_reflectance`,t]]:[[e,t]])]]}function vd(e,t){if(typeof t==`string`)return`string`;if(t===!0)return`boolean`;let n=[`reflectance`,`specular_reflectance`,`k`,`eta`].includes(e);return typeof t==`number`&&!n?`float`:`rgb`}function yd({vertices:e,faces:t}){let n=[`x`,`y`,`z`,`nx`,`ny`,`nz`,`u`,`v`].map(e=>`property float ${e}`),r=[`ply`,`format binary_little_endian 1.0`,`element vertex ${e.length/8}`,...n,`element face ${t.length/3}`,`property list uchar int vertex_indices`,`end_header
`].join(`
`),i=new TextEncoder().encode(r),a=new Uint8Array(i.length+4*e.length+13*t.length/3);a.set(i);let o=new DataView(a.buffer),s=i.length;for(let t of e)o.setFloat32(s,t,!0),s+=4;for(let e=0;e<t.length;e+=3){o.setUint8(s,3);for(let n=0;n<3;n++)o.setInt32(s+1+4*n,t[e+n],!0);s+=13}return a}function bd(e){let{mesh:t}=e;return Dn({"scene.xml":new TextEncoder().encode(xd(e)),"object.ply":yd(t),[`environment.${e.environment.suffix}`]:e.environment.bytes,"material.safetensors":e.material})}function xd(e){let{mesh:t,view:n,rotation:r,width:i,height:a,environment:o}=e,{eye:s,up:c,forward:l}=zs(t,n,i/a),u=s.map((e,t)=>e+l[t]);return`<scene version="3.0.0">
    <default name="spp" value="256"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <string name="fov_axis" value="y"/>
        <float name="fov" value="${360/Math.PI*Math.atan(Math.hypot(...c))}"/>
        <transform name="to_world">
            <lookat origin="${s.join(`, `)}" target="${u.join(`, `)}" up="${c.join(`, `)}"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="${i}"/>
            <integer name="height" value="${a}"/>
            <string name="pixel_format" value="rgb"/>
            <rfilter type="box"/>
        </film>
        <sampler type="independent">
            <integer name="sample_count" value="$spp"/>
        </sampler>
    </sensor>
    <emitter type="envmap" id="environment">
        <string name="filename" value="environment.${o.suffix}"/>
        <transform name="to_world">
            <rotate x="1" angle="90"/>
            <rotate z="1" angle="${r}"/>
        </transform>
    </emitter>
${e.lights.map(e=>Sd(e,r)).join(``)}\
    <shape type="ply" id="object">
        <string name="filename" value="object.ply"/>
        <bsdf type="neural_brdf">
            <string name="filename" value="material.safetensors"/>
        </bsdf>
    </shape>
</scene>
`}function Sd({direction:e,power:t},n){let r=e.map(e=>-e).join(`, `);return`    <emitter type="directional">
        <rgb name="irradiance" value="${t.join(`, `)}"/>
        <transform name="to_world">
            <lookat origin="0, 0, 0" target="${r}" up="0.36, 0.48, 0.8"/>
            <rotate z="1" angle="${n}"/>
        </transform>
    </emitter>
`}function Cd(){if(Vc.value===null)throw new B(`The networks are not loaded yet.`);return Vc.value}async function wd(){let e=Er(q.value),t=Xc(q.value)?.table,{core:n,material:r}=await Cd().cores.material({stack:e,table:t});return{core:n,codes:r}}var Td=()=>q.value.rotation??0;async function Ed(){let{bottom:e}=q.value;if(e.kind!==`texels`){let{core:e,codes:t}=await wd();return Ko(t,e,Td())}let t=Do.get(e.texture);if(t===void 0)throw new B(`The texture was not opened.`);return t.texture.file}var Dd=[{label:`Picture`,hint:`PNG, as it is seen`,save:async e=>{Nd(`${e}.png`,await Cd().picture()),Ad()}},{label:`Copy the address`,hint:`to share: it holds the whole state`,save:async()=>{let e=new URL(`#${ll(K.value)}`,location.href).href;try{await navigator.clipboard.writeText(e)}catch{throw new B(`The browser gives the page no clipboard; copy the address from the address bar.`)}Li(`The address was copied.`)}},{label:`Material`,hint:`safetensors, for urushi.load`,save:async e=>Nd(`${e}.safetensors`,await Ed())}],Od=(e,t)=>({label:t,hint:`PNG of a larger picture, drawn to the end`,save:async t=>Nd(`${t}-${e}.png`,await Cd().largePicture(e))}),kd={"Larger pictures and linear light":[Od(`2x`,`2 ×`),Od(`4K`,`4K`),{label:`Radiance`,hint:`EXR, the picture in linear light`,save:async e=>{Nd(`${e}.exr`,Ac(await Cd().radiance())),Ad()}}],"Scenes and descriptions":[{label:`Mitsuba scene`,hint:`ZIP: object, camera, light and material`,save:async e=>{let t={...await Cd().scene(),material:await Ed()};Nd(`${e}-scene.zip`,bd(t))}},{label:`Mitsuba XML`,hint:`a BSDF for a scene file`,save:e=>Nd(`${e}.xml`,hd(q.value))},{label:`Python`,hint:`a program with urushi`,save:e=>Nd(`${e}.py`,cd(q.value))},{label:`MaterialX`,hint:`an open_pbr_surface, without what that lacks`,save:e=>{let{text:t,lost:n}=Zu(q.value);Nd(`${e}.mtlx`,t),n&&Ji(n)}},{label:`State`,hint:`JSON, to open here again`,save:e=>Nd(`${e}.json`,cl(K.value,2))}],"Shaders of f, pdf and sample":Object.keys(ka).map(e=>({label:ka[e].title,hint:`${ka[e].title} code`,save:t=>jd(e,t)})),"The texture that they read":Object.keys(Hu).map(e=>({label:Hu[e],hint:`the functions of the basis, the same for all materials`,save:async()=>{let{core:t}=await wd();Nd(`urushi-basis.${e}`,Ku(await t.basisTexels(),e))}}))};function Ad(){let{converged:e,gathered:t}=Cd().painter;e.value||Ji(`The picture was saved while refining, with ${Math.round(100*t.value)} % of its frames; wait until it has converged, or save 2 × or 4K, which are drawn to the end.`)}async function jd(e,t){let{core:n,codes:r}=await wd(),i=ja(await Aa(e,n.widths),r,Td());Nd(`${t}${ka[e].suffix}`,i),r.table.isOfCodes?Md(r)||Ji(`Shader code stretches all channels alike: under this pigment of two widths, f can differ from the page's by 10 % and more.`):Ji(`The shader code has the codes of the material; for its table, save the material and run urushi export.`)}function Md({table:{stretches:e=[0]}}){return Math.max(...e)-Math.min(...e)<.05}function Nd(e,t){let n=document.createElement(`a`);n.href=URL.createObjectURL(new Blob([t])),n.download=e,n.click(),setTimeout(()=>URL.revokeObjectURL(n.href),1e4)}async function Pd(e){try{await e.save(dd(q.value.name))}catch(t){X(t,()=>void Pd(e))}}function Fd({onDone:e}){let t=t=>t.map(t=>Q(`li`,{children:Q($,{title:t.hint,onClick:()=>{e(),Pd(t)},children:[Q(`span`,{children:t.label}),Q(`small`,{children:t.hint})]})},t.label));return Q(x,{children:[Q(`ul`,{children:t(xt()?Dd.filter(e=>!e.hint.includes(`share`)):Dd)}),Object.entries(kd).map(([e,n])=>Q(`section`,{children:[Q(`h2`,{children:e}),Q(`ul`,{class:`compact`,children:t(n)})]},e))]})}var Id={neutral:`Neutral (Khronos)`,filmic:`Filmic (ACES)`,none:`None (sRGB)`},Ld={environment:`Environment`,colour:`Colour`,transparent:`Transparent`},Rd=`#f2f2f2`;function zd({onDone:e}){let{view:t,background:n,tone:r,turntable:i}=K.value,a=n.startsWith(`#`),o=async()=>{e();try{await document.getElementById(xu).requestFullscreen()}catch{X(new B(`The browser does not let the page fill the screen.`))}};return Q(x,{children:[Q(Fu,{label:`Field of view`,hint:`Angle of the lens; the object keeps its size. Double click: reset.`,text:`${t.fov}°`,value:t.fov,low:5,high:60,step:1,fallback:Si.view.fov,onInput:e=>Y({view:{...K.value.view,fov:e}})}),Q(`label`,{children:[Q(`span`,{children:`Background`}),Q(Cl,{value:a?`colour`:n,options:Object.entries(Ld),onChange:e=>J({background:e===`colour`?Rd:e})}),a&&Q(`input`,{type:`color`,class:`swatch`,"aria-label":`Colour of the background`,value:n,onInput:e=>J({background:e.currentTarget.value},`background`)})]}),Q(`label`,{children:[Q(`span`,{children:`Tone curve`}),Q(Cl,{value:r,options:_i.map(e=>[e,Id[e]]),onChange:e=>J({tone:e})})]}),Q(`label`,{title:Du()?`Your system asks for less motion.`:void 0,children:[Q(`span`,{children:`Turntable`}),Q(`input`,{type:`checkbox`,checked:i,disabled:Du(),onChange:e=>Y({turntable:e.currentTarget.checked})})]}),Q(`div`,{class:`pair`,children:[Q($,{class:`text-button`,onClick:()=>Y({view:Si.view}),children:`Reset camera`}),document.fullscreenEnabled&&Q($,{class:`text-button`,onClick:()=>void o(),children:`Full screen`})]})]})}function Bd(){let e=Te(null),{comparison:t,active:n}=K.value,r=t===`off`?``:`AB`[n];return Q(`header`,{class:`top`,children:[Q(`h1`,{children:[Q(`svg`,{viewBox:`0 0 20 20`,"aria-hidden":`true`,children:[Q(`path`,{d:`M3 13.5 10 17l7-3.5M3 10l7 3.5L17 10`}),Q(`path`,{class:`lacquer`,d:`m10 3 7 3.5-7 3.5-7-3.5Z`})]}),`Urushi`]}),Q(zu,{kind:`presets`,name:`Material ${r} ${fi(q.value)}: choose another`,label:Q(x,{children:[r&&Q(`b`,{class:`badge`,children:r}),` `,Q(`span`,{class:`current`,children:fi(q.value)}),Q(_l,{name:`down`})]}),children:e=>Q(Bu,{onChosen:e})}),Q(`span`,{class:`spacer`}),Q(vl,{name:`Undo`,title:`Undo (Ctrl+Z)`,icon:`undo`,"aria-disabled":!Hi.value,onClick:Gi}),Q(vl,{name:`Redo`,title:`Redo (Ctrl+Shift+Z)`,icon:`redo`,"aria-disabled":!Ui.value,onClick:Ki}),Q(`input`,{ref:e,type:`file`,hidden:!0,multiple:!0,accept:`.hdr,.exr,.obj,.glb,.gltf,.ply,.json,.safetensors`,onChange:e=>{el([...e.currentTarget.files??[]]),e.currentTarget.value=``}}),Q($,{class:`text-button`,"aria-label":`Open`,title:`A material (.safetensors), a panorama (.hdr, .exr), a mesh (.obj, .glb, .gltf, .ply) or a saved state (.json); or drop it on the page`,onClick:()=>e.current?.click(),children:Vd(`open`,`Open`)}),Q(zu,{kind:`view`,name:`View`,label:Vd(`sliders`,`View`),children:e=>Q(zd,{onDone:e})}),Q(zu,{kind:`save`,name:`Save`,label:Vd(`save`,`Save`),children:e=>Q(Fd,{onDone:e})}),Q(lu,{})]})}function Vd(e,t){return Q(x,{children:[Q(_l,{name:e}),Q(`span`,{children:t})]})}function Hd(){return Q(x,{children:[Q($,{class:`skip`,onClick:()=>document.getElementById(`material`)?.focus(),children:`Skip to the layers`}),Q(Bd,{}),Q(`main`,{children:[Q(Su,{}),Q(Lu,{}),Q(`div`,{class:`column`,children:[Q(`aside`,{id:`material`,tabIndex:-1,"aria-label":`Material`,children:[K.value.comparison!==`off`&&Q(Wd,{}),Q(Ud,{}),Q(iu,{})]}),Q(du,{})]})]}),Q(uu,{}),Q(`p`,{class:`spoken`,role:`status`,children:Fi.value})]})}function Ud(){let{name:e}=q.value;return Q(`input`,{type:`text`,class:`name`,"aria-label":`Name of the material`,maxLength:80,autocomplete:`off`,spellcheck:!1,value:e,onChange:({currentTarget:t})=>{let n=t.value.trim();n===``?t.value=e:n!==e&&Wi({...q.value,name:n})},onKeyDown:({key:e,currentTarget:t})=>{e===`Enter`&&t.blur()}})}function Wd(){let{active:e,materials:t}=K.value,[n,r]=t,i=e===0?`B`:`A`,a=(e,t)=>{J({materials:e}),Li(t)},o=t[e];return Q(x,{children:[Q(wl,{name:`Material on the cards`,value:e,options:[0,1].map(e=>[e,Q(x,{children:[Q(`b`,{children:`AB`[e]}),` `,fi(t[e])]},e)]),onChange:e=>J({active:e})}),Q(`div`,{class:`pair`,children:[Q($,{class:`quiet`,onClick:()=>a([o,o],`The material was copied to ${i}.`),children:[`Copy to `,i]}),Q($,{class:`quiet`,onClick:()=>a([r,n],`A and B were swapped.`),children:[Q(_l,{name:`swap`}),` Swap`]})]})]})}var Gd=`button, select, input, [tabindex]`;function Kd(){let e=null;document.addEventListener(`focusin`,({target:t})=>{e=t}),new MutationObserver(t=>{if(e===null||e.isConnected||document.activeElement!==document.body)return;let n=t.find(({removedNodes:t})=>[...t].some(t=>t.contains(e)));if(n===void 0)return;let r=[n.nextSibling,n.previousSibling,n.target].filter(e=>e instanceof Element&&e.isConnected).map(e=>[...e.querySelectorAll(Gd)]),i=e.getAttribute(`title`),a=r.flat().find(e=>i&&e.title===i),o=r.find(e=>e.length>0)?.[0],s=n.target.parentElement?.querySelector(Gd);(a??o??s)?.focus()}).observe(document.body,{childList:!0,subtree:!0})}var qd=()=>location.hash.length>1,Jd=qd();Jd&&Yi(()=>ul(location.hash),!1);var Yd=location.hash,Xd=0;tt(()=>{K.value,xt()||Xd!==0||(Xd=window.setTimeout(()=>{Xd=0,Yd=`#${ll(K.peek())}`,history.replaceState(null,``,Yd)},400))}),tt(()=>{document.title=`${fi(q.value)} · Urushi`}),window.addEventListener(`hashchange`,()=>{qd()&&location.hash!==Yd&&Yi(()=>ul(location.hash),!0)}),window.addEventListener(`keydown`,e=>{let t=e.ctrlKey||e.metaKey?e.key.toLowerCase():``;e.target instanceof HTMLInputElement&&[`text`,`search`].includes(e.target.type)||t!==`z`&&t!==`y`||(e.preventDefault(),t===`y`||e.shiftKey?Ki():Gi())}),window.addEventListener(`unhandledrejection`,e=>X(e.reason)),al(document.documentElement),Kd();var Zd=document.getElementById(`page`);Zd.replaceChildren(),le(Q(Hd,{}),Zd),Wc(Jd);